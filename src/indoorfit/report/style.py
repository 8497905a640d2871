"""The look of the report page, on screens light and dark and on paper."""

STYLE = """
:root { color-scheme: light dark; --ink: #1d2b36; --quiet: #5c646b; --paper: #fbfaf7; --card: #fff;
  --rule: #dcd8cf; --accent: #0f6ab4; --warn: #a84c06; --warn-back: #fdf3e7; --lit: #ffe3bf; --bar: #7fa8c9; }
@media screen and (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --quiet: #a2abb3; --paper: #16191c;
  --card: #1f2327; --rule: #363c42; --accent: #6cb4ef; --warn: #f0a35e; --warn-back: #33261a; --lit: #4d3716;
  --bar: #4a7495; }
  .plan > svg:not(.histogram) { filter: invert(.9) hue-rotate(180deg); } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 2rem 1.5rem 4rem; background: var(--paper);
  color: var(--ink); font: 16px/1.55 system-ui, "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .7rem; }
h3 { font-size: 1rem; margin: 1.6rem 0 .4rem; }
p { max-width: 46rem; margin: .5rem 0; }
.quiet { color: var(--quiet); font-size: .93rem; }
.unseen { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
.plan { background: var(--card); border: 1px solid var(--rule); border-radius: 8px; padding: .5rem;
  overflow-x: auto; }
.plan svg { display: block; width: 100%; height: auto; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; background: var(--card); }
th, td { text-align: left; padding: .38rem .7rem; border-bottom: 1px solid var(--rule); }
th { font-weight: 600; color: var(--quiet); vertical-align: bottom; }
td { overflow-wrap: break-word; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number, td.id { white-space: nowrap; }
td.what { min-width: 17rem; }
td.id, td.id button { color: var(--accent); font-weight: 600; }
td.inferred { color: var(--warn); font-weight: 600; }
tr[data-pick] { cursor: pointer; }
tr[data-pick]:hover { background: color-mix(in srgb, var(--accent) 7%, transparent); }
tr.lit, figure.lit { background: var(--lit) !important; }
button, summary { font: inherit; color: inherit; cursor: pointer; }
button { background: var(--card); border: 1px solid var(--rule); border-radius: 6px; padding: .3rem .75rem; }
button[aria-pressed=true] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
button:hover { border-color: var(--accent); }
:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
th button { background: none; border: 0; padding: 0; font: inherit; text-align: inherit; }
th[aria-sort] button::after { content: " \\25B2"; font-size: .7em; }
th[aria-sort=descending] button::after { content: " \\25BC"; }
button.pick { padding: .05rem .5rem; min-width: 2.2rem; }
.tools { display: flex; flex-wrap: wrap; gap: .5rem .9rem; align-items: center; max-width: none;
  margin: 0 0 .6rem; font-size: .93rem; }
.tools label { display: inline-flex; gap: .35rem; align-items: center; }
.slide output { min-width: 9.5em; color: var(--quiet); font-variant-numeric: tabular-nums; }
#stage { position: relative; width: 100%; aspect-ratio: 16 / 10; max-height: 82vh; overflow: hidden;
  border: 1px solid var(--rule); border-radius: 8px;
  background: linear-gradient(color-mix(in srgb, var(--card) 80%, var(--accent) 14%), var(--card)); }
#stage.flat { display: none; }
#stage canvas { display: block; width: 100%; height: 100%; touch-action: none; border-radius: 8px; }
#stage canvas:focus-visible { outline-offset: -3px; }
.labels { position: absolute; inset: 0; pointer-events: none; overflow: hidden;
  font: 12px/1.35 system-ui, "Helvetica Neue", Arial, sans-serif; }
.labels span { position: absolute; transform: translate(-50%, -50%); white-space: nowrap; display: none;
  pointer-events: auto; cursor: pointer; border-radius: 4px; padding: 0 .35em; }
.labels .dimension { background: color-mix(in srgb, var(--card) 88%, transparent); color: var(--ink);
  font-variant-numeric: tabular-nums; }
.labels .name { color: #fff; background: #26323ca8; font-size: 11px; }
.labels .lit { background: #ff8a1e; color: #201000; font-weight: 600; z-index: 1; }
#says { min-height: 1.6em; }
#picked { position: fixed; z-index: 3; left: 50%; bottom: .8rem; transform: translateX(-50%); margin: 0;
  width: max-content; max-width: calc(100vw - 1.6rem); padding: .5rem .9rem; border-radius: 8px;
  background: var(--card); border: 1px solid var(--rule); box-shadow: 0 3px 16px #0004; font-size: .93rem; }
#picked[hidden] { display: none; }
#picked a, #picked button { margin-left: .5rem; }
a { color: var(--accent); }
svg [data-shows] { cursor: pointer; }
svg path.lit { stroke: #e06c00 !important; stroke-width: 4px !important; }
svg text.lit { fill: #c75d00 !important; font-weight: 700; }
.histogram { max-width: 44rem; margin: auto; font-size: 12px; }
.histogram rect { fill: var(--bar); } .histogram text { fill: var(--ink); }
.histogram path { fill: none; stroke: var(--ink); }
.histogram .curve { stroke: var(--warn); stroke-width: 2; }
.scale { font-size: .9rem; color: var(--quiet); }
.ramp { display: inline-block; width: 9rem; height: .8em; margin: 0 .4em; vertical-align: -1px;
  border: 1px solid var(--rule); background: linear-gradient(90deg, #2166ac, #f7f7f7, #b2182b);
  print-color-adjust: exact; }
.maps { display: grid; grid-template-columns: repeat(auto-fill, minmax(10rem, 1fr)); gap: .8rem; }
figure { margin: 0; padding: .4rem; background: var(--card); border: 1px solid var(--rule);
  border-radius: 6px; display: flex; flex-direction: column; justify-content: flex-end; }
figure img { width: 100%; max-height: 9rem; object-fit: contain; image-rendering: pixelated; }
figcaption { font-size: .8rem; color: var(--quiet); line-height: 1.35; padding-top: .3rem; }
details > summary { padding: .3rem 0; }
.warning { background: var(--warn-back); border-left: 4px solid var(--warn); padding: .5rem .9rem;
  margin: .5rem 0; max-width: none; overflow-wrap: anywhere; }
code { font-size: .88em; overflow-wrap: anywhere; }
@media (max-width: 40rem) { body { padding: 1rem .8rem 3rem; } h1 { font-size: 1.35rem; }
  #stage { aspect-ratio: 4 / 5; } th, td { padding: .38rem .45rem; } button { min-height: 2.3rem; } }
@media print { :root { color-scheme: light; --paper: #fff; --card: #fff; --ink: #000; --quiet: #333;
    --rule: #bbb; --accent: #000; --warn: #000; --warn-back: #fff; --lit: #eee; }
  body { max-width: none; padding: 0; font-size: 9.5pt; } h2 { break-after: avoid; margin-top: 1.4rem; }
  tr, .plan, .warning, figure, #stage { break-inside: avoid; } .tools, #keys, #says { display: none; }
  #picked { display: none !important; } td.what { min-width: 9rem; } #stage { background: none; }
  .wide { overflow: visible; } table { font-size: 8pt; } th, td { padding: .2rem .35rem; }
  body, td { line-height: 1.35; }
  th button, button.pick { border: 0; padding: 0; min-width: 0; min-height: 0; box-shadow: none !important; }
  #stage { max-height: 115mm; } .labels { font-size: 8pt; } .plan svg { max-height: 235mm; }
  @page { size: A4; margin: 14mm; } }
"""
