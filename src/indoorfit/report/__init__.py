"""What people see: plan, tables, page and picture."""

from .dxf import to_dxf as to_dxf
from .layout import UNIT_MM as UNIT_MM
from .page import report_html as report_html
from .pdf import to_pdf as to_pdf
from .plan import plan_picture as plan_picture
from .plan import plan_svg as plan_svg
from .plan import write_picture_png as write_picture_png
from .plan import write_plan_png as write_plan_png
from .render import View as View
from .render import render_png as render_png
from .residuals import Residuals as Residuals
from .residuals import residuals_of as residuals_of
from .sheet import Sheet as Sheet
from .sheet import plan_layout as plan_layout
from .sheet import plan_sheet as plan_sheet
from .svg import to_svg as to_svg
from .table import dimension_table as dimension_table
from .versus import versus_document as versus_document
from .versus import versus_table as versus_table
from .versus_picture import versus_picture as versus_picture
