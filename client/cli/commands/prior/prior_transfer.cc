// SPDX-License-Identifier: Apache-2.0
// `enfilade prior add` and `enfilade prior export`.
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/prior/plan_options.h"
#include "client/cli/commands/prior/prior_map_output.h"
#include "client/cli/map_file_import.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

struct PriorAddOptions {
  PlanOptions plan;
  std::string name;
  std::string id;
  int level = 0;
};

struct PriorExportOptions {
  std::string plan;
  std::string directory;
  std::vector<std::string> products;
};

const std::map<std::string, v1::PriorMapProduct>& Products() {
  static const std::map<std::string, v1::PriorMapProduct> products = {{"sheet", v1::PRIOR_MAP_PRODUCT_SHEET},
                                                                      {"plan", v1::PRIOR_MAP_PRODUCT_PLAN},
                                                                      {"corrected", v1::PRIOR_MAP_PRODUCT_CORRECTED},
                                                                      {"planning", v1::PRIOR_MAP_PRODUCT_PLANNING},
                                                                      {"picture", v1::PRIOR_MAP_PRODUCT_PICTURE}};
  return products;
}

absl::StatusOr<v1::ImportPriorMapManifest> PlanManifest(const Globals& globals, const PriorAddOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const perception::ReadPlanOptions reading, ToReadOptions(options.plan));
  v1::ImportPriorMapManifest manifest;
  manifest.set_parent(SiteNameOf(globals));
  manifest.set_prior_map_id(options.id);
  manifest.set_display_name(options.name);
  manifest.set_level(options.level);
  manifest.set_page(reading.page);
  manifest.mutable_layers()->Assign(reading.layers.begin(), reading.layers.end());
  manifest.set_plan_level(reading.level);
  if (reading.measure) *manifest.mutable_measure() = MeasureToProto(*reading.measure);
  return manifest;
}

absl::Status RunPriorAdd(const Globals& globals, const PriorAddOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::ImportPriorMapManifest manifest, PlanManifest(globals, options));
  ProgressBar bar(globals, "uploading", 0, "B");
  ENFILADE_ASSIGN_OR_RETURN(
      const v1::PriorMap added,
      client::ImportPriorMap(ConnectionOf(globals), manifest, std::filesystem::path(options.plan.path), ShownBy(bar)));
  bar.Finish();
  for (const std::string& warning : added.warnings()) std::cerr << "warning: " << warning << '\n';
  PrintPriorMap(globals, "added", added);
  if (!globals.json) std::cout << ElementsText(added.elements()) << '\n';
  return absl::OkStatus();
}

absl::Status RunPriorExport(const Globals& globals, const PriorExportOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found,
                            client::FindPriorMap(connection, SiteId(globals.site), options.plan));
  std::vector<v1::PriorMapProduct> products;
  for (const std::string& product : options.products) products.push_back(Products().at(product));
  ProgressBar bar(globals, "downloading", 0, "B");
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<std::filesystem::path> files,
      client::ExportPriorMap(connection, found.name(), products, options.directory, ShownBy(bar)));
  bar.Finish();
  nlohmann::json document = {{"name", found.name()}, {"files", nlohmann::json::array()}};
  for (const std::filesystem::path& path : files) {
    document["files"].push_back(path.string());
    if (!globals.json) std::cout << path.string() << '\n';
  }
  if (globals.json) PrintJson(std::cout, document);
  return absl::OkStatus();
}

}  // namespace

void AddPriorAdd(CLI::App& prior, const Globals& globals) {
  const auto options = std::make_shared<PriorAddOptions>();
  CLI::App* command = AddCommand(prior, "add", "Upload a floor plan to the site",
                                 [&globals, options] { return RunPriorAdd(globals, *options); });
  AddPlanOptions(*command, options->plan, "--plan-level");
  command->add_option("--name", options->name, "Its name for people, unique in the site")->required();
  command->add_option("--id", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\" (default: a new one)");
  command->add_option("--level", options->level, "The floor, as of the maps that it is a plan of")
      ->capture_default_str();
  command->footer(
      "Examples:\n  enfilade prior add floor.png --name \"Ground floor\" --measure 120,40,480,40=7.2\n"
      "  enfilade prior add house.dxf --name \"First floor\" --level 1 --layers 'A-WALL*,A-DOOR*'");
}

void AddPriorExport(CLI::App& prior, const Globals& globals) {
  const auto options = std::make_shared<PriorExportOptions>();
  CLI::App* command = AddCommand(prior, "export", "Write a plan, and what was made of it, as files",
                                 [&globals, options] { return RunPriorExport(globals, *options); });
  command->add_option("PLAN", options->plan, "Its name, id or resource name")->required();
  command->add_option("-o,--output", options->directory, "The folder to write to")->required();
  std::vector<std::string> names;
  for (const auto& [name, product] : Products()) names.push_back(name);
  command
      ->add_option("--product", options->products,
                   "sheet (the file that was added), plan (what was read in it), corrected (its walls in the world), "
                   "planning (a map for Nav2) or picture; may be repeated (default: all that there are)")
      ->check(CLI::IsMember(names));
  command->footer(
      "Examples:\n  enfilade prior export \"Ground floor\" -o ground\n"
      "  enfilade prior export \"Ground floor\" -o ground --product corrected --product planning");
}

}  // namespace enfilade::cli
