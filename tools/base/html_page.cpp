// SPDX-License-Identifier: Apache-2.0
#include "tools/base/html_page.h"

namespace thew::tools {

const char* const kPageStyle = R"css(
:root { color-scheme: light; --ink: #1d2329; --soft: #5c6670; --rule: #e3e6e9; --paper: #fff; }
* { box-sizing: border-box; }
body { margin: 0; background: #f4f5f6; color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 32px 24px 48px; }
h1 { margin: 0; font-size: 30px; line-height: 1.2; font-weight: 650; letter-spacing: -.01em; }
h2 { margin: 36px 0 12px; font-size: 18px; font-weight: 650; }
p { margin: 4px 0; max-width: 80ch; }
.soft, figcaption { color: var(--soft); }
.verdict { margin: 18px 0; padding: 12px 16px; border-radius: 6px; border-left: 5px solid;
  background: var(--paper); font-size: 16px; max-width: none; }
.good { border-color: #1a7f4b; } .bad { border-color: #b3261e; } .none { border-color: #98a1aa; }
.good b { color: #14663c; } .bad b { color: #b3261e; }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(140px, 1fr)); gap: 1px; margin: 0;
  background: var(--rule); border: 1px solid var(--rule); border-radius: 6px; overflow: hidden; }
dl div { background: var(--paper); padding: 10px 14px; }
dt { color: var(--soft); font-size: 12.5px; }
dd { margin: 0; font-size: 19px; font-variant-numeric: tabular-nums; }
dd small { display: block; font-size: 13px; color: var(--soft); }
code { font: 13px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace; overflow-wrap: anywhere; }
figure { margin: 0; padding: 16px; background: var(--paper); border: 1px solid var(--rule);
  border-radius: 6px; }
figure img { display: block; width: 100%; height: auto; }
figcaption { margin-top: 8px; font-size: 13.5px; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(520px, 100%), 1fr)); gap: 16px; }
svg { display: block; width: 100%; height: auto; font: 12px system-ui, sans-serif; }
svg .title { font-size: 15px; font-weight: 600; fill: var(--ink); }
svg .tick, svg .unit { fill: var(--soft); font-size: 12px; font-weight: 400; } svg .label { font-weight: 500; }
svg .grid { stroke: var(--rule); } svg .leader { opacity: .45; }
svg .line { fill: none; stroke-width: 1.7; stroke-linejoin: round; }
svg line.limit { stroke: #b3261e; stroke-dasharray: 6 4; } svg text.limit { fill: #b3261e; }
svg g:hover .line { stroke-width: 3.5; }
.wide { overflow-x: auto; background: var(--paper); border: 1px solid var(--rule); border-radius: 6px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: 7px 12px; text-align: right; white-space: nowrap; border-top: 1px solid var(--rule); }
thead th { border-top: 0; font-weight: 600; font-size: 13px; color: var(--soft); vertical-align: bottom; }
th:first-child, td:first-child, .named td { text-align: left; }
.named td { white-space: normal; overflow-wrap: anywhere; } .named th { font-weight: 400; color: var(--soft); }
td i { display: inline-block; width: 10px; height: 10px; border-radius: 2px; margin-right: 8px; }
footer { margin-top: 36px; color: var(--soft); font-size: 13.5px; }
@media print { body { background: #fff; } figure, .wide { break-inside: avoid; } }
)css";

}  // namespace thew::tools
