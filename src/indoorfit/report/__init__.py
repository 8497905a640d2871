"""What people see: plan, tables, page and picture."""

from .page import report_html as report_html
from .plan import plan_picture as plan_picture
from .plan import plan_svg as plan_svg
from .plan import write_picture_png as write_picture_png
from .plan import write_plan_png as write_plan_png
from .render import View as View
from .render import render_png as render_png
from .svg import to_svg as to_svg
from .table import dimension_table as dimension_table
from .versus import versus_document as versus_document
from .versus import versus_table as versus_table
from .versus_picture import versus_picture as versus_picture
