#pragma once

namespace feder::experiments {

/// The whole style sheet of the page.
inline constexpr const char* kPageStyle = R"(
:root { color-scheme: light; }
body { margin: 0 auto; padding: 1.5rem; max-width: 1250px; color: #222; background: #fff;
       font: 16px/1.5 system-ui, sans-serif; }
h1 { margin: 0 0 .25rem; }
h2 { margin: 3rem 0 .25rem; padding-top: 1rem; border-top: 2px solid #ddd; }
nav { margin: 1rem 0; }
nav a { margin-right: 1.2rem; }
a { color: #0b5394; }
.question { font-size: 1.15rem; margin: .25rem 0 1rem; }
.bad { background: #fdecea; border-left: 4px solid #c0392b; padding: .5rem .8rem; }
.limits { color: #555; }
figure { margin: 1.5rem 0; overflow-x: auto; }
figure svg { max-width: 100%; height: auto; display: block; }
figcaption { color: #444; margin-top: .3rem; }
.scroll { max-height: 24rem; overflow: auto; border: 1px solid #ddd; }
table { border-collapse: collapse; font-size: .85rem; white-space: nowrap; }
th { position: sticky; top: 0; background: #f2f2f2; text-align: left; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #eee; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
tr.failed td { background: #fdf3e7; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
pre { background: #f7f7f7; padding: .8rem; overflow: auto; font-size: .85rem; }
)";

}  // namespace feder::experiments
