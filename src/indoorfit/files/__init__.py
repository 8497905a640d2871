"""Files and directories that appear whole or not at all.

The work goes to a sibling with a temporary name, which is renamed at the end. This guards against
errors and interrupts of the program, not against a loss of power (nothing is flushed to the disk).
"""

from .directory import atomic_directory as atomic_directory
from .directory import check_output_directory as check_output_directory
from .names import FormatName as FormatName
from .single import atomic_file as atomic_file
from .single import replace_file as replace_file
from .together import check_staged as check_staged
from .together import staged as staged
