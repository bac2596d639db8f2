// SPDX-License-Identifier: Apache-2.0
#include "report/page_assets.h"

namespace sinew::report {

const std::string_view page_style = R"css(
:root {
  color-scheme: light dark;
  --paper: #ffffff; --ink: #1c1c1e; --soft: #5c5f64; --rule: #dcdee1; --tint: #f5f6f7;
  --axis: #8c9096; --grid: rgba(0, 0, 0, .09); --zero: rgba(0, 0, 0, .38); --cursor: rgba(0, 0, 0, .45);
  --link: #0060a0; --finding: #009e73; --caution: #d55e00; --selector: #d5dde5; --selector-line: #8796a5;
}
@media screen and (prefers-color-scheme: dark) {
  :root:not(.printing) {
    --paper: #17191c; --ink: #e4e5e7; --soft: #a3a7ad; --rule: #383c42; --tint: #1f2226;
    --axis: #7d828a; --grid: rgba(255, 255, 255, .10); --zero: rgba(255, 255, 255, .42);
    --cursor: rgba(255, 255, 255, .5); --link: #7fc0ec; --finding: #2fbf95; --caution: #f08a4b;
    --selector: #2f3a45; --selector-line: #6d7f90;
  }
}
:root.printing { color-scheme: light; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body {
  margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "Helvetica Neue", Arial, "Liberation Sans", sans-serif;
  font-feature-settings: "kern", "liga";
}
main { max-width: 1120px; margin: 0 auto; padding: 40px 32px 56px; }
h1 { font-size: 30px; line-height: 1.2; font-weight: 650; letter-spacing: -.01em; margin: 0 0 10px; }
h2 { font-size: 21px; line-height: 1.3; font-weight: 650; margin: 48px 0 10px; padding-top: 14px;
     border-top: 1px solid var(--rule); }
h3 { font-size: 17px; line-height: 1.35; font-weight: 650; margin: 30px 0 8px; }
p, ul, ol { max-width: 74ch; margin: 0 0 12px; }
li { margin: 2px 0; }
h1, h2, h3, p, li, .name { overflow-wrap: anywhere; }
td, th { overflow-wrap: break-word; }
a { color: var(--link); text-underline-offset: 2px; }
.lead { font-size: 19px; line-height: 1.45; color: var(--soft); max-width: 66ch; margin-bottom: 20px; }
.finding, .caution { max-width: 78ch; margin: 18px 0; padding: 12px 16px; background: var(--tint);
                     border-left: 3px solid var(--finding); }
.caution { border-left-color: var(--caution); }
.finding p, .caution p { margin: 0; }
.finding p + p, .caution p + p { margin-top: 8px; }
.contents { margin: 22px 0 8px; padding: 12px 0; border-top: 1px solid var(--rule);
            border-bottom: 1px solid var(--rule); font-size: 15px; }
.contents h2 { all: unset; display: block; font-size: 13px; color: var(--soft); margin-bottom: 4px; }
.contents ol { columns: 2; column-gap: 40px; max-width: none; margin: 0; padding-left: 22px; }
.contents li { break-inside: avoid; }
.contents a { text-decoration: none; }
.contents a:hover, .contents a:focus-visible { text-decoration: underline; }
:focus-visible { outline: 2px solid var(--link); outline-offset: 2px; }

pre { margin: 0; padding: 12px 14px; background: var(--tint); border-radius: 4px; overflow-x: auto;
      font: 13px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, "Liberation Mono", "DejaVu Sans Mono", monospace; }
figure { margin: 18px 0 22px; }
.caption, .thinned { font-size: 14px; line-height: 1.45; color: var(--soft); max-width: 84ch; margin: 6px 0 0; }
figcaption { font-weight: 600; font-size: 15px; line-height: 24px; }

.table { overflow-x: auto; }
table { border-collapse: collapse; font-size: 14.5px; line-height: 1.4; margin-top: 6px;
        font-variant-numeric: tabular-nums lining-nums; border-bottom: 1.2px solid var(--axis); }
th, td { padding: 5px 22px 5px 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--rule); }
th:last-child, td:last-child { padding-right: 4px; }
td:first-child, th:first-child { padding-left: 4px; }
thead th { font-weight: 600; color: var(--soft); font-size: 13px; vertical-align: bottom;
           border-bottom: 1.2px solid var(--axis); }
table:not(:has(thead)) { border-top: 1.2px solid var(--axis); }
.scrolls { display: none; font-size: 13px; color: var(--soft); margin: 2px 0 0; }
.right { text-align: right; }
td.right { white-space: nowrap; }
tr.emphasis td { font-weight: 650; background: var(--tint); }
tr.noted td { border-bottom: 0; padding-bottom: 0; }
tr.note td { font-size: 13.5px; color: var(--soft); padding-top: 1px; white-space: normal; max-width: 84ch; }

.plot { position: relative; margin: 14px 0 18px; }
.head { display: flex; flex-wrap: wrap; align-items: center; gap: 2px 18px; margin: 0 8px 2px 0; min-height: 27px; }
.head figcaption { margin-right: 4px; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 16px; font-size: 13.5px; flex: 1 1 auto; }
.legend label { display: inline-flex; align-items: center; gap: 6px; cursor: pointer; min-height: 24px; }
.legend input { margin: 0; width: 14px; height: 14px; accent-color: var(--soft); flex: none; }
.legend svg { flex: none; display: block; }
.legend input:not(:checked) ~ * { opacity: .45; }
.when, .value { font-variant-numeric: tabular-nums lining-nums; color: var(--soft); white-space: nowrap; }
.value { display: inline-block; text-align: right; color: var(--ink); }
.when { font-size: 13.5px; text-align: right; }
.time .reset { margin-left: auto; }
.scatter .reset { position: absolute; z-index: 11; top: 12px; right: 18px; }
.reset { font: inherit; font-size: 13px; padding: 1px 9px; border: 1px solid var(--rule); border-radius: 4px;
         background: var(--paper); color: var(--ink); cursor: pointer; visibility: hidden; }
.zoomed .reset { visibility: visible; }
.reset:hover { background: var(--tint); }
.bands { position: relative; overflow: hidden; font-size: 12px; line-height: 16px; color: var(--soft); }
.bands span { position: absolute; white-space: nowrap; overflow: hidden; text-overflow: ellipsis; padding-left: 4px;
              border-left: 1.5px solid var(--axis); height: 15px; }
.chart { position: relative; width: 100%; }
.chart:focus { outline: none; }
.chart:focus-visible { outline: 2px solid var(--link); outline-offset: 1px; }
.chart.by-mouse:focus-visible { outline: none; }
.chart .cursor { position: absolute; width: 1px; background: var(--cursor); pointer-events: none; z-index: 8;
                 display: none; }
.chart .empty { position: absolute; color: var(--soft); font-size: 14px; pointer-events: none; z-index: 8; }
.scatters { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 430px), 1fr)); gap: 0 36px; }
.scatter canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
.tip { position: absolute; z-index: 12; pointer-events: none; display: none; max-width: 300px; padding: 4px 8px;
       border: 1px solid var(--rule); border-radius: 4px; background: var(--paper); font-size: 13px; line-height: 1.4;
       font-variant-numeric: tabular-nums lining-nums; box-shadow: 0 1px 4px rgba(0, 0, 0, .12); }
.hint { font-size: 13px; color: var(--soft); margin: 16px 0 0; max-width: none; }
kbd { font: inherit; font-size: 12px; padding: 0 4px; border: 1px solid var(--rule); border-radius: 3px; }
.spoken { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
footer { margin-top: 56px; padding-top: 12px; border-top: 1px solid var(--rule); font-size: 13px; color: var(--soft); }
footer p { margin: 0 0 2px; max-width: none; overflow-wrap: anywhere; }

.dygraph-axis-label { color: var(--soft); font-size: 12px; line-height: 1; font-variant-numeric: tabular-nums; }
.dygraph-ylabel { font-size: 12.5px; line-height: 1.1; color: var(--ink); }

@media (max-width: 760px) {
  main { padding: 24px 16px 40px; }
  h1 { font-size: 25px; }
  .lead { font-size: 17px; }
  .contents ol { columns: 1; }
  th, td { padding-right: 14px; }
}
@media screen and (max-width: 760px) {
  th, td { min-width: calc(var(--least, 0ch) + 18px); }
  .scrolls.wide { display: block; }
}
@media screen and (max-width: 480px) {
  .scrolls { display: block; }
}
@media print {
  @page { size: A4; margin: 12mm 13mm; }
  html { color-scheme: light; }
  .contents { display: none; }
  h2 { margin-top: 26px; }
  .table { overflow: visible; }
  table { font-size: 13px; line-height: 1.3; }
  th, td { padding: 3px 12px 3px 0; }
  thead th { font-size: 12px; }
  tr.note td { font-size: 12px; }
  footer { margin-top: 24px; }
  .reset, .hint, .when, .value, .cursor, .tip { display: none !important; }
  .legend input { display: none; }
  .legend label:has(input:not(:checked)) { display: none; }
  .plot, tr, pre, .finding, .caution { break-inside: avoid; }
  tr.noted, h1, h2, h3, figcaption { break-after: avoid; }
  a { color: inherit; text-decoration: none; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
.printing main { width: 980px; max-width: none; padding: 0; margin: 0; zoom: .7; }
.printing p, .printing ul, .printing ol { max-width: none; }
.printing .scatters { grid-template-columns: 1fr 1fr 1fr; gap: 0 24px; }
)css";

}  // namespace sinew::report
