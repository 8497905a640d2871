"""The look of the report page, on screens light and dark and on paper."""

STYLE = """
:root { color-scheme: light dark; --ink: #1d2b36; --quiet: #5c646b; --paper: #fbfaf7; --card: #fff;
  --rule: #dcd8cf; --accent: #0f6ab4; --warn: #b4540a; --warn-back: #fdf3e7; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --quiet: #a2abb3; --paper: #16191c;
  --card: #1f2327; --rule: #363c42; --accent: #6cb4ef; --warn: #f0a35e; --warn-back: #33261a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 68rem; padding: 2rem 1.5rem 4rem; background: var(--paper);
  color: var(--ink); font: 16px/1.55 system-ui, "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .7rem; }
p { max-width: 46rem; margin: .5rem 0; }
.quiet { color: var(--quiet); }
.plan { background: #fff; border: 1px solid var(--rule); border-radius: 8px; padding: .5rem;
  overflow-x: auto; }
.plan svg { display: block; width: 100%; height: auto; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; background: var(--card); }
th, td { text-align: left; padding: .38rem .7rem; border-bottom: 1px solid var(--rule); }
th { font-weight: 600; color: var(--quiet); white-space: nowrap; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.id { color: var(--accent); font-weight: 600; }
td.inferred { color: var(--warn); font-weight: 600; }
.warning { background: var(--warn-back); border-left: 4px solid var(--warn); padding: .5rem .9rem;
  margin: .5rem 0; max-width: none; overflow-wrap: anywhere; }
code { font-size: .88em; overflow-wrap: anywhere; }
@media print { :root { --paper: #fff; --card: #fff; --ink: #000; --quiet: #444; --rule: #bbb;
    --accent: #000; --warn: #000; --warn-back: #fff; }
  body { max-width: none; padding: 0; font-size: 10pt; } h2 { break-after: avoid; }
  tr, .plan, .warning { break-inside: avoid; } @page { margin: 16mm; } }
"""
