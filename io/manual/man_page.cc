// SPDX-License-Identifier: Apache-2.0
#include "io/manual/man_page.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "fmt/format.h"

namespace enfilade::io {
namespace {

// As man(7) prints `text` unchanged: a hyphen is no minus there, and a line that begins with a dot is a request.
std::string Escaped(std::string_view text) {
  std::string escaped;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
    line_begins = c == '\n';
  }
  return escaped;
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string Dashed(std::string path) {
  std::replace(path.begin(), path.end(), ' ', '-');
  return path;
}

// Lines that begin with a space keep their breaks.
std::string Paragraphs(const std::string& text) {
  std::string page;
  std::istringstream lines(text);
  bool kept = false;
  for (std::string line; std::getline(lines, line);) {
    const bool keep = !line.empty() && line.front() == ' ';
    if (keep != kept) page += keep ? ".nf\n" : ".fi\n";
    kept = keep;
    page += line.empty() ? ".PP\n" : Escaped(line) + "\n";
  }
  return kept ? page + ".fi\n" : page;
}

std::string ValueOf(const CLI::Option& option) {
  if (option.get_expected_max() == 0) return "";
  const std::string name = option.get_type_name();
  return name.empty() ? "VALUE" : name;
}

std::string OptionEntry(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("\\fB\\-" + Escaped(name) + "\\fR");
  for (const std::string& name : option.get_lnames()) names.push_back("\\fB\\-\\-" + Escaped(name) + "\\fR");
  std::string entry = fmt::format(".TP\n{}", fmt::join(names, ", "));
  if (const std::string value = ValueOf(option); !value.empty()) entry += " \\fI" + Escaped(value) + "\\fR";
  entry += "\n" + Escaped(option.get_description());
  if (!option.get_default_str().empty()) entry += Escaped(fmt::format(" (default: {})", option.get_default_str()));
  if (option.get_required()) entry += " (required)";
  if (!option.get_envname().empty()) entry += Escaped(fmt::format(" [${}]", option.get_envname()));
  return entry + "\n";
}

std::string PositionalName(const CLI::Option& option) {
  return option.get_expected_max() > 1 ? option.get_name(true) + "..." : option.get_name(true);
}

std::string Options(const CLI::App& command) {
  std::string page;
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) continue;
    page += fmt::format(".TP\n\\fI{}\\fR\n{}\n", Escaped(PositionalName(*option)), Escaped(option->get_description()));
  }
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional() && option != command.get_help_ptr()) page += OptionEntry(*option);
  }
  return page;
}

std::string Synopsis(const CLI::App& command, const std::string& path) {
  std::string line = "\\fB" + Escaped(path) + "\\fR [\\fIOPTIONS\\fR]";
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) continue;
    const std::string name = "\\fI" + Escaped(PositionalName(*option)) + "\\fR";
    line += option->get_required() ? " " + name : " [" + name + "]";
  }
  if (!command.get_subcommands({}).empty()) line += " \\fICOMMAND\\fR ...";
  return line;
}

// The commands below `command`, the inner ones after those that hold them.
std::string Commands(const CLI::App& command, const std::string& path) {
  std::string page;
  for (const CLI::App* inner : command.get_subcommands({})) {
    const std::string inner_path = path + " " + inner->get_name();
    page += ".SS " + Synopsis(*inner, inner_path) + "\n" + Paragraphs(inner->get_description()) + Options(*inner);
    if (!inner->get_footer().empty()) page += ".PP\n" + Paragraphs(inner->get_footer());
    page += Commands(*inner, inner_path);
  }
  return page;
}

}  // namespace

std::string ManPage(const CLI::App& command, const std::string& path, const ManPageOptions& options) {
  const std::string name = Dashed(path);
  std::string page = fmt::format(".TH {} {} \"\" \"Enfilade {}\" \"Enfilade\"\n", Escaped(Upper(name)), options.section,
                                 options.version);
  page += fmt::format(".SH NAME\n{} \\- {}\n", Escaped(name), Escaped(command.get_description()));
  page += ".SH SYNOPSIS\n" + Synopsis(command, path) + "\n";
  if (!command.get_footer().empty()) page += ".SH EXAMPLES\n" + Paragraphs(command.get_footer());
  if (const std::string listed = Options(command); !listed.empty()) page += ".SH OPTIONS\n" + listed;
  if (const std::string listed = Commands(command, path); options.commands && !listed.empty()) {
    page += ".SH COMMANDS\n" + listed;
  }
  for (const auto& [title, text] : options.sections) page += ".SH " + Escaped(title) + "\n" + Paragraphs(text);
  if (!options.see_also.empty()) page += ".SH SEE ALSO\n" + options.see_also + "\n";
  return page;
}

}  // namespace enfilade::io
