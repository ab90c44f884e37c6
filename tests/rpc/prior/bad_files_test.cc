// SPDX-License-Identifier: Apache-2.0
// Files of every format that are no plans: each is refused by name, and nothing of it is stored.
#include <cstdint>
#include <string>
#include <vector>

#include "core/grid/files/png_codec.h"
#include "fmt/format.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/plans/pdf_plan.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string BlankPng() {
  return grid::EncodePng(
             grid::PixelImage{
                 .width = 400, .height = 300, .channels = 1, .samples = std::vector<std::uint8_t>(120'000, 255)})
      .value();
}

// Whose header says 20,000 x 20,000 pixels.
std::string HugePng() {
  std::string png = BlankPng();
  for (const std::size_t at : {16, 20}) png.replace(at, 4, std::string("\0\0\x4E\x20", 4));
  return png;
}

std::string GeoJson(const std::string& frame, const std::string& geometry) {
  return fmt::format(
      R"({{"type":"FeatureCollection",{}"features":[{{"type":"Feature","properties":{{}},"geometry":{}}}]}})", frame,
      geometry);
}

struct BadFile {
  const char* name;
  std::string bytes;
  const char* message;
};

class BadFilesTest : public PriorMapFixture {};

TEST_F(BadFilesTest, AreRefusedByNameAndStoreNothing) {
  const std::string metres = R"("frame":"metres",)";
  const std::string vertices = R"(vertices: [[0, 0, 0, ""], [90, 0, 0, ""]])";
  const std::string measured = "measurements: [[0, 1, {distance: [3, 9]}]]";
  const std::string block =
      "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nLOOP\n0\nINSERT\n8\n0\n2\nLOOP\n0\nENDBLK\n0\nENDSEC\n";
  const std::vector<BadFile> files = {
      {"text.png", "This is no picture.", "neither PNG nor JPEG"},
      {"truncated.png", BlankPng().substr(0, BlankPng().size() / 2), "ends within the image"},
      {"huge.png", HugePng(), "20000x20000"},
      {"blank.png", BlankPng(), "0 walls, 8 needed"},
      {"book.pdf", PdfPlan(300), "300 pages: choose one (page)"},
      {"secret.pdf", EncryptedPdfPlan(), "encrypted"},
      {"uses.svg", R"(<svg xmlns="http://www.w3.org/2000/svg"><g id="g"><use href="#g"/></g></svg>)", "use of \"#g\""},
      {"entities.svg",
       R"(<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY x SYSTEM "file:///etc/passwd">]>)"
       R"(<svg xmlns="http://www.w3.org/2000/svg"><text>&a;&x;</text><script>alert(1)</script></svg>)",
       "0 walls, 8 needed"},
      {"loop.dxf", block + "0\nSECTION\n2\nENTITIES\n0\nINSERT\n8\n0\n2\nLOOP\n0\nENDSEC\n0\nEOF\n", "block \"LOOP\""},
      {"crossing.geojson", GeoJson(metres, R"({"type":"Polygon","coordinates":[[[0,0],[4,4],[4,0],[0,4],[0,0]]]})"),
       "crosses itself"},
      {"nan.geojson", GeoJson("", R"({"type":"LineString","coordinates":[[11.5,NaN],[11.6,48]]})"), "GeoJSON"},
      {"beyond.geojson", GeoJson("", R"({"type":"LineString","coordinates":[[11,48],[200,48]]})"), "longitude 200"},
      {"unmeasured.building.yaml", "levels: {L1: {" + vertices + ", walls: [[0, 1, {}]]}}", "no measured line"},
      {"index.building.yaml", "levels: {L1: {" + vertices + ", " + measured + ", walls: [[0, 7, {}]]}}",
       "a vertex that does not exist"},
  };
  for (const BadFile& file : files) {
    v1::ImportPriorMapManifest manifest = Manifest();
    manifest.mutable_file()->set_name(file.name);
    EXPECT_STATUS(ImportPlan(file.bytes, manifest), absl::StatusCode::kInvalidArgument,
                  AllOf(HasSubstr(file.name), HasSubstr(file.message)));
  }
  for (const char* table : {"prior_maps", "prior_map_files", "blobs"}) {
    EXPECT_EQ(database_.SqlValue(fmt::format("SELECT count(*) FROM enfilade.{}", table)), "0") << table;
  }
}

}  // namespace
}  // namespace enfilade::testing
