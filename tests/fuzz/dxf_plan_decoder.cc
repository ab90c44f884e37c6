// SPDX-License-Identifier: Apache-2.0
// Floor plans in DXF, up to the planar graph.
#include "core/prior/formats/dxf_plan.h"
#include "tests/fuzz/plan_promises.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  const std::string header = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n";
  const std::string end = "0\nENDSEC\n0\nEOF\n";
  std::string rooms;
  for (int i = 0; i <= 4; ++i) {
    const std::string x = std::to_string(3000 * i);
    rooms += "0\nLINE\n8\nA-WALL\n10\n" + x + "\n20\n0\n11\n" + x + "\n21\n9000\n";
    rooms += "0\nLINE\n8\nA-WALL\n10\n0\n20\n" + x + "\n11\n12000\n21\n" + x + "\n";
  }
  return {
      header + "0\nSECTION\n2\nENTITIES\n" + rooms + end,
      header + "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nROOM\n0\nLINE\n8\n0\n10\n0\n20\n0\n11\n10\n21\n0\n0\nENDBLK\n" +
          "0\nBLOCK\n2\nTWO\n0\nINSERT\n8\n0\n2\nROOM\n10\n5\n20\n6\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" +
          "0\nINSERT\n8\nA-WALL\n2\nTWO\n10\n100\n20\n50\n41\n2\n42\n2\n50\n90\n" + end,
      "999\na comment\n0\nSECTION\n2\nENTITIES\n"
      "0\nLWPOLYLINE\n8\nA-WALL\n90\n3\n70\n1\n43\n120\n10\n0\n20\n0\n42\n1\n10\n1000\n20\n0\n10\n1000\n20\n1000\n"
      "0\nPOLYLINE\n8\nA-WALL\n70\n0\n0\nVERTEX\n10\n0\n20\n5\n0\nVERTEX\n10\n7\n20\n5\n42\n-0.5\n0\nSEQEND\n"
      "0\nARC\n8\n0\n10\n0\n20\n0\n40\n1000\n50\n0\n51\n180\n" +
          end};
}

bool Decode(std::string_view bytes) {
  const auto drawing = prior::ReadDxfPlan(bytes);
  if (!drawing.ok()) return false;
  ExpectLines(drawing->graph);
  ExpectPlanFile(bytes);
  return true;
}

}  // namespace enfilade::fuzz
