// SPDX-License-Identifier: Apache-2.0
// Floor plans in SVG, up to the planar graph.
#include "core/prior/formats/svg_plan.h"
#include "tests/fuzz/plan_promises.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  const std::string begin = R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 200">)";
  return {
      begin + R"svg(<rect x="0" y="0" width="400" height="200"/><path d="M100 0V80M100 110V200M200 0v80m0 30V200"/>
<g id="Walls" transform="translate(10 20) rotate(90, 3 4) scale(2)" style="stroke-width:3; stroke-dasharray: none">
<line x1="0" y1="0" x2="50" y2="0"/><polyline points="0,0 10,0 10,5 30 7"/><polygon points="0 0 20 0 20 40"/></g></svg>)svg",
      begin + R"svg(<defs><g id="w"><line x1="0" y1="0" x2="5" y2="0"/></g><symbol id="s"><use href="#w"/></symbol>
</defs><use href="#w" x="10" y="2"/><use xlink:href="#s" transform="matrix(1 0 0 -1 0 50) skewX(3) skewY(2)"/>
<path d="M10 0 A10 5 30 0 1 -10 0 Q 3 4 5 6 T 8 9 C0 5 10 5 10 0 S20-5 20 0 l1.5-.5h4H3v1z"/>
<script>alert(1)</script><image href="http://example.org/a.png"/></svg>)svg",
      R"(<?xml version="1.0"?><!DOCTYPE svg [<!ENTITY a "aa"><!ENTITY b "&a;&a;"><!ENTITY x SYSTEM "file:///x">]>)" +
          begin + R"(<text>&b;&x;</text><line x1="0" y1="0" x2="1" y2="0"/></svg>)"};
}

bool Decode(std::string_view bytes) {
  const auto drawing = prior::ReadSvgPlan(bytes);
  if (!drawing.ok()) return false;
  ExpectLines(drawing->graph);
  const auto again = prior::ReadSvgPlan(prior::WriteSvgPlan(drawing->graph));
  Expect(again.ok(), "a plan that is written is SVG");
  ExpectPlanFile(bytes);
  return true;
}

}  // namespace enfilade::fuzz
