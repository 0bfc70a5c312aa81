"""The style sheet of the page: screen, phone, print."""

CSS = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0 auto; max-width: 70rem; padding: 2.5rem 1.5rem 4rem; background: #fff; color: #1b1b1b;
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", Arial,
    sans-serif; }
h1, h2, h3, h4 { line-height: 1.2; font-weight: 650; overflow-wrap: anywhere; }
h1 { font-size: 2rem; margin: 0 0 .3rem; letter-spacing: -.015em; }
h2 { font-size: 1.4rem; margin: 3.5rem 0 1rem; padding-top: .8rem; border-top: 2px solid #1b1b1b; }
h2 .no { color: #767676; font-weight: 400; margin-right: .35rem; }
h3 { font-size: 1.1rem; margin: 2.4rem 0 .7rem; }
h4 { font-size: 1rem; margin: 1rem 0 .4rem; }
h3 .sub, h4 .sub { font-weight: 400; color: #555; margin-left: .3rem; }
p, ul, dl { margin: 0 0 1rem; }
p, li, dd { overflow-wrap: anywhere; }
a { color: #005a8d; }
a:focus-visible, .scroll:focus-visible, pre:focus-visible, thead th button:focus-visible { outline: 2px solid #0072B2;
  outline-offset: 2px; }
code, pre { font-family: ui-monospace, "SFMono-Regular", Menlo, Consolas, "DejaVu Sans Mono", monospace;
  font-size: .86em; }
.run { color: #555; margin: 0 0 1.2rem; }
.lead { max-width: 50rem; font-size: 1.06rem; }
.files { font-size: .84em; color: #555; margin: 0 0 1rem; }
svg.plot + .files { margin: 0 0 .3rem; padding-left: .2rem; }
.kind { display: inline-block; font-size: .78em; font-weight: 600; line-height: 1.3; padding: 0 .4em;
  border: 1px solid #767676; border-radius: .3em; color: #444; background: #f5f5f5; white-space: nowrap; }
.kind.good { border-color: #009E73; color: #00664b; background: #eef7f3; }
.kind.bad { border-color: #D55E00; color: #8f3f00; background: #fdf0e6; }
.small { font-size: .84em; color: #555; font-weight: 400; }
.state { margin: 0 0 1.2rem; padding: .55rem .9rem; border-left: 5px solid #009E73; background: #eef7f3; }
.state.banner { border-color: #D55E00; background: #fdf0e6; }
.notes { border: 1px solid #d5d5d5; padding: .7rem 1rem; margin: 0 0 1.2rem; font-size: .92rem; }
.notes p { margin: 0 0 .3rem; font-weight: 650; } .notes ul { margin: 0; padding-left: 1.1rem; }
.toc { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .25rem 1.4rem;
  font-size: .94rem; }
.scroll { overflow-x: auto; margin: 0 0 1.2rem; max-width: 100%; }
@media screen {
  /* A shadow at the side where more is hidden: white covers it where the content ends. */
  .scroll { background:
      linear-gradient(to right, #fff 30%, rgba(255, 255, 255, 0)) 0 0 / 2.5rem 100% local,
      linear-gradient(to left, #fff 30%, rgba(255, 255, 255, 0)) 100% 0 / 2.5rem 100% local,
      linear-gradient(to right, rgba(0, 0, 0, .22), rgba(0, 0, 0, 0)) 0 0 / .8rem 100% scroll,
      linear-gradient(to left, rgba(0, 0, 0, .22), rgba(0, 0, 0, 0)) 100% 0 / .8rem 100% scroll;
    background-repeat: no-repeat; }
}
table { border-collapse: collapse; min-width: 100%; font-variant-numeric: tabular-nums;
  font-size: .92rem; line-height: 1.35; }
caption { text-align: left; color: #555; padding: 0 0 .5rem; font-size: .92rem; }
caption { position: sticky; left: 0; max-width: min(calc(100vw - 3rem), 67rem); }
th, td { padding: .42rem .8rem; text-align: right; vertical-align: baseline; white-space: nowrap; }
th { font-weight: 650; }
thead th { border-bottom: 1.5px solid #1b1b1b; vertical-align: bottom; font-size: .88rem; }
tbody tr { border-bottom: 1px solid #e3e3e3; }
tbody tr:last-child { border-bottom: 1.5px solid #1b1b1b; }
th:first-child { text-align: left; padding-left: .2rem; position: sticky; left: 0; background: #fff;
  background-clip: padding-box; z-index: 1; }
.nb { white-space: nowrap; }
.text { text-align: left; }
.texts td, .texts thead th { text-align: left; }
.texts td { white-space: normal; overflow-wrap: anywhere; min-width: 6rem; }
.overview thead th:nth-child(n+3):not(:nth-child(6)):not(:nth-child(8)) { text-align: left; }
.overview th:first-child, .compared th:first-child { white-space: normal; min-width: 7rem; max-width: 13rem;
  overflow-wrap: break-word; }
.overview thead th { white-space: normal; min-width: 3.4rem; }
.compared td, .compared thead th { padding-left: .3rem; padding-right: 1.2rem; }
.results td, .results thead th { padding-right: 1.35rem; }
.stages { margin-top: 2.4rem; } .stages thead th:nth-child(2) { text-align: left; }
.times th, .times td, .times thead th { padding-left: .45rem; padding-right: .6rem; }
.times th:first-child { white-space: normal; min-width: 9rem; }
td.best { position: relative; }
.mark { position: absolute; right: .3rem; font-size: .8em; color: #005a8d; }
tr.paper th, tr.paper td, tr.paper th:first-child { background-color: #eef3f8; color: #33475b; }
tr.paper th { font-weight: 400; font-style: italic; }
.compared td, .compared th { vertical-align: top; }
.map svg.plot { max-width: 42rem; } .map.wide svg.plot { max-width: none; min-width: 60rem; }
.single svg.plot { max-width: 44rem; }
table.findings td { min-width: 15rem; } table.findings td:last-child { min-width: 5.5rem; }
tr.heading th, tr.heading th:first-child { text-align: left; font-size: .84em; color: #33475b; background: #eef3f8;
  padding: .3rem .2rem; }
tr.baseline th, tr.baseline td, td.base { color: #5c5c5c; font-style: italic; }
tr.baseline { background: #f5f5f5; } tr.baseline th:first-child { background-color: #f5f5f5; }
.off, tr.unused { display: none !important; }
.switches { position: sticky; top: 0; z-index: 5; margin: 1.5rem 0 0; padding: .45rem .8rem; background: #f5f5f5;
  border: 1px solid #d5d5d5; font-size: .92rem; }
.switches summary { cursor: pointer; font-weight: 650; }
.boxes { display: flex; flex-wrap: wrap; gap: .15rem 1rem; align-items: baseline; padding-top: .35rem;
  max-height: 30vh; overflow-y: auto; }
.boxes label { white-space: nowrap; } .boxes input { margin: 0 .35rem 0 0; vertical-align: -.08em; }
.boxes button { font: inherit; padding: 0 .6rem; }
thead th button { font: inherit; color: inherit; text-align: inherit; white-space: inherit; cursor: pointer;
  background: none; border: 0; padding: 0; margin: 0; min-width: 1em; min-height: 1em; }
.sortable thead th:not(:first-child) { position: relative; }
thead th button::after { content: ""; position: absolute; margin-left: .15em; font-weight: 400; }
thead th button:hover::after, thead th button:focus-visible::after { content: "\\2195"; color: #767676; }
thead th[aria-sort] button::after { color: #005a8d; font-weight: 650; }
thead th[aria-sort=ascending] button::after { content: "\\2191"; }
thead th[aria-sort=descending] button::after { content: "\\2193"; }
.none { color: #5c5c5c; font-style: italic; }
.results td.none { text-align: left; }
.zero { color: #767676; }
ul.findings { padding-left: 1.1rem; } .findings li { margin-bottom: .6rem; max-width: 54rem; }
.figure { margin: 1rem 0 1.4rem; }
figcaption { color: #555; font-size: .9rem; }
.panels { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .6rem 1.2rem; }
.panels.two { grid-template-columns: repeat(2, minmax(0, 1fr)); }
svg.plot { display: block; width: 100%; height: auto; }
svg text { font-family: inherit !important; }
svg.plot *, svg.swatch * { stroke-linecap: butt; stroke-linejoin: round; }
.legend { list-style: none; padding: 0; margin: 0 0 .5rem; display: flex; flex-wrap: wrap;
  gap: .2rem 1.3rem; font-size: .92rem; }
.legend li { display: flex; align-items: center; gap: .4rem; }
svg.swatch { width: 36px; height: 14px; flex: none; }
.colours { margin-bottom: 1rem; }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr));
  gap: 1.2rem; }
.cell figure { margin: 0; }
.cell img { display: block; width: 100%; height: auto; border: 1px solid #d5d5d5; cursor: zoom-in; }
.cell figcaption { margin-top: .35rem; } .cell figcaption b { color: #1b1b1b; margin-right: .25rem; }
.close { display: none; }
.missing { border: 1px dashed #aaa; padding: 2rem 1rem; margin: 0; text-align: center; color: #555;
  font-size: .9rem; }
dt { font-weight: 650; margin-top: .9rem; } dd { margin: .1rem 0 0; max-width: 50rem; }
pre { background: #f5f5f5; padding: .9rem 1rem; overflow-x: auto; line-height: 1.45; }
footer { margin-top: 3rem; padding-top: .8rem; border-top: 1px solid #d5d5d5; color: #555;
  font-size: .88rem; }
@media screen {
  .cell figure:target { position: fixed; z-index: 9; top: 0; right: 0; bottom: 0; left: 0;
    background: #fff; padding: 1rem;
    display: flex; flex-direction: column; overflow: auto; }
  .cell figure:target .open { flex: 1 1 auto; min-height: 0; display: flex; align-items: center;
    justify-content: center; }
  .cell figure:target img { width: 100%; height: 100%; object-fit: contain; border: 0; cursor: default; }
  .cell figure:target .close { display: inline-block; order: -1; align-self: flex-end;
    padding: .4rem .8rem; margin-bottom: .4rem; }
}
@media screen and (max-width: 800px) {
  .panels, .panels.two { grid-template-columns: minmax(0, 1fr); }
}
@media screen and (max-width: 560px) {
  body { padding: 1.4rem 1rem 3rem; }
  h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.6rem; }
  h3 .sub, h4 .sub { display: block; margin: .15rem 0 0; font-size: .95rem; }
  table { font-size: .86rem; } th, td { padding: .4rem .6rem; }
  th:first-child { min-width: 5.6rem; max-width: 9.5rem; white-space: normal; overflow-wrap: break-word; }
  .map svg.plot { min-width: 36rem; }
}
@media screen and (max-width: 560px) {
  table.findings thead { display: none; }
  table.findings tr, table.findings th, table.findings td { display: block; max-width: none; }
  table.findings th, table.findings td { padding: .25rem .2rem; }
}
@media print {
  @page { size: A4; margin: 13mm; }
  html { font-size: 9.5pt; } body { max-width: none; padding: 0; font-size: 9.5pt; }
  h2 { margin-top: 1.6rem; }
  h1, h2, h3, h4, caption, .legend { page-break-after: avoid; break-after: avoid; }
  .scroll { overflow: visible; } .compared td, .compared thead th { padding-left: .1rem; padding-right: 1rem; }
  .overview td .small { white-space: nowrap; } table.findings a, .files { display: none; }
  table { font-size: 8pt; page-break-inside: avoid; break-inside: avoid; }
  table.long { page-break-inside: auto; break-inside: auto; } thead { display: table-header-group; }
  th, td { padding: .25rem .35rem; } .results td, .results thead th { padding-right: 1rem; }
  thead th { white-space: normal; }
  .text, .none { white-space: normal; } th:first-child, caption { position: static; }
  tr, .figure, .cell, dt { page-break-inside: avoid; break-inside: avoid; } dt { break-after: avoid; }
  .grid { grid-template-columns: repeat(2, 1fr); }
  pre { white-space: pre-wrap; overflow-wrap: anywhere; }
  nav, .switches { display: none; } a { color: inherit; text-decoration: none; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
"""
