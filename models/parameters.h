// Binds the members of a model's option struct to parameters with text, unit and range, so that defaults and
// checks stand in one place: the struct and its field list.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "models/model.h"
#include "models/modes.h"

namespace feder {

/// Allowed values, from `least` to `greatest` (`open`: without the two ends). `rigid` also admits infinity,
/// written "inf" or "rigid".
struct Range {
  double least, greatest;
  bool open = false, rigid = false, integer = false;

  bool contains(double value) const;
  std::string expectation() const;
};
extern const Range kAnyNumber, kPositive, kNonNegative, kPositiveOrRigid;
/// At least `least`, at most the nodes a scene may have.
Range count_from(int least);

/// Largest scene accepted: nodes and rows (about 100 bytes per row).
inline constexpr double kMaxNodes = 1e7, kMaxRows = 3e7;
/// Throws InputError if `count` (a product, taken in double before any allocation) exceeds `greatest`.
void require_count(const std::string& place, const std::string& name, double count, double greatest);

double parse_number(const std::string& place, const std::string& name, const std::string& text,
                    const Range& range);
int parse_count(const std::string& place, const std::string& name, const std::string& text,
                const Range& range);
std::vector<Mode> parse_modes(const std::string& place, const std::string& name, const std::string& text);
int parse_choice(const std::string& place, const std::string& name, const std::string& text,
                 const std::vector<std::string>& choices);
void require_in(const std::string& place, const std::string& name, double value, const std::string& unit,
                const Range& range);
std::string to_text(double value);
std::string to_text(const std::vector<Mode>& modes);

/// Text from outside for a message: at most 60 characters, no control characters, in quotes.
std::string quoted(const std::string& text);
std::string join(const std::vector<std::string>& words, const char* separator = ", ");
/// The word that needs the fewest edits to become `text`; "" if there is none.
std::string nearest(const std::string& text, const std::vector<std::string>& words);

/// One parameter of a model with options `Options`.
template <class Options>
struct Field {
  Parameter info;
  std::function<void(Options&, const std::string& place, const std::string& text)> read;
  std::function<void(const Options&, const std::string& place)> check;
};
template <class Options>
using Fields = std::vector<Field<Options>>;

template <class Options>
Field<Options> field(const char* name, double Options::*member, const char* unit, const char* what,
                     const Range& range) {
  return {{name, to_text(Options{}.*member), unit, what, range.expectation()},
          [=](Options& options, const std::string& place, const std::string& text) {
            options.*member = parse_number(place, name, text, range);
          },
          [=](const Options& options, const std::string& place) {
            require_in(place, name, options.*member, unit, range);
          }};
}

template <class Options>
Field<Options> field(const char* name, int Options::*member, const char* what, const Range& range) {
  return {{name, std::to_string(Options{}.*member), "", what, range.expectation()},
          [=](Options& options, const std::string& place, const std::string& text) {
            options.*member = parse_count(place, name, text, range);
          },
          [=](const Options& options, const std::string& place) {
            require_in(place, name, options.*member, "", range);
          }};
}

template <class Options>
Field<Options> field(const char* name, std::vector<Mode> Options::*member, const char* what) {
  return {{name, to_text(Options{}.*member), "m", what,
           "mode:amplitude/mode:amplitude..., negative modes from the end"},
          [=](Options& options, const std::string& place, const std::string& text) {
            options.*member = parse_modes(place, name, text);
          },
          [=](const Options& options, const std::string& place) {
            for (const Mode& mode : options.*member) require_in(place, name, mode.amplitude, "m", kAnyNumber);
          }};
}

/// An enum whose values 0, 1, ... are called `choices`.
template <class Options, class Enum>
Field<Options> field(const char* name, Enum Options::*member, const char* what,
                     const std::vector<std::string>& choices) {
  return {{name, choices[static_cast<std::size_t>(Options{}.*member)], "", what, "one of " + join(choices)},
          [=](Options& options, const std::string& place, const std::string& text) {
            options.*member = static_cast<Enum>(parse_choice(place, name, text, choices));
          },
          [](const Options&, const std::string&) {}};
}

/// Throws InputError at the first member outside its range. Every make_... function starts with it.
template <class Options>
void check_fields(const std::string& place, const Fields<Options>& fields, const Options& options) {
  for (const Field<Options>& f : fields) f.check(options, place);
}

/// Throws InputError: no parameter `key`, with the nearest name and the list.
[[noreturn]] void fail_unknown_parameter(const std::string& place, const std::string& key,
                                         const std::vector<Parameter>& parameters);

/// A catalogue entry from a field list and a make function.
template <class Options>
ModelInfo describe(const std::string& name, const std::string& description, const Fields<Options>& fields,
                   Model (*make)(const Options&), std::vector<Preset> presets = {}) {
  ModelInfo info{name, description, {}, std::move(presets), {}};
  for (const Field<Options>& f : fields) info.parameters.push_back(f.info);
  info.build = [=, parameters = info.parameters, place = "model " + name](const Settings& settings) {
    Options options;
    for (const Setting& setting : settings) {
      bool found = false;
      for (const Field<Options>& f : fields)
        if (f.info.name == setting.key) f.read(options, place, setting.value), found = true;
      if (!found) fail_unknown_parameter(place, setting.key, parameters);
    }
    return make(options);
  };
  return info;
}

}  // namespace feder
