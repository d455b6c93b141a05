// Binds the keys of a scene table to the members of a struct, so that reading, checking and the reference
// page come from one list.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/system.h"
#include "models/parameters.h"
#include "models/scene_file/diagnostics.h"
#include "models/scene_file/value.h"

namespace feder {

/// A value with the place to complain about; `given` is false where the file leaves it out.
template <class T>
struct Placed {
  T value{};
  TextPlace place{};
  bool given = false;
};

/// Text that names something else in the scene.
using NameText = Placed<std::string>;
using PlacedNumber = Placed<double>;
using PlacedVector = Placed<Vector3d>;

/// What the end of a row is tied to: a name, a point of a body ("point" in the body's axes, "place" in the
/// world at the start), or a fixed place of the world (a vector).
struct AnchorText {
  NameText name;
  Placed<Vector3d> point, place;
};

/// A scalar function: a constant, an expression, or a table of pairs.
struct FunctionText {
  enum class Kind { kNone, kNumber, kExpression, kTable };
  Kind kind = Kind::kNone;
  TextPlace place = {};
  double number = 0.0;
  std::string expression = {};
  std::vector<std::array<double, 2>> pairs = {};
};

/// How a body is turned at the start.
struct Orientation {
  Matrix3d axes = Matrix3d::Identity();
};

/// What the reference page says about a key.
struct KeyInfo {
  std::string name, unit, what, expectation, default_value;
  bool required = false;
};

/// One key of a table that fills an `Entry`.
template <class Entry>
struct Key {
  KeyInfo info;
  std::function<void(Entry&, const Value&, const std::string& where, Diagnostics&)> read;
};
template <class Entry>
using Keys = std::vector<Key<Entry>>;

/// A range in words, infinity as scene files write it.
std::string expectation_of(const KeyInfo& key, const Range& range);

// Readers of one value. Each reports what it does not like as "<where>: <key> = <value>, expected ..." and
// then leaves `out` alone.
using Out = Diagnostics&;
void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                PlacedNumber& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                double& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                int& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, bool& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, NameText& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, std::string& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, PlacedVector& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, Vector3d& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where,
                std::vector<AnchorText>& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, AnchorText& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, FunctionText& out,
                Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where,
                std::array<FunctionText, 3>& out, Out problems);
void read_value(const KeyInfo& key, const Value& value, const std::string& where, Orientation& out,
                Out problems);
/// A numeric list of `range`.
void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                std::vector<double>& out, Out problems);
void read_direction(const KeyInfo& key, const Value& value, const std::string& where, Vector3d& out,
                    Out problems);
void read_direction(const KeyInfo& key, const Value& value, const std::string& where, PlacedVector& out,
                    Out problems);
/// A word of `choices` as its place in the list.
void read_choice(const KeyInfo& key, const Value& value, const std::string& where,
                 const std::vector<std::string>& choices, int& out, Out problems);
void read_words(const KeyInfo& key, const Value& value, const std::string& where,
                const std::vector<std::string>& choices, std::vector<std::string>& out, Out problems);
/// "", "x", "xy" ... as a mask.
void read_mask(const KeyInfo& key, const Value& value, const std::string& where, FreeMask& out, Out problems);

/// Reports keys the table does not have and required ones that are missing.
void check_keys(const Value& table, const std::vector<KeyInfo>& keys, const std::string& where,
                TextPlace place, Diagnostics& problems);

template <class Entry>
std::vector<KeyInfo> infos(const Keys<Entry>& keys) {
  std::vector<KeyInfo> list;
  for (const Key<Entry>& key : keys) list.push_back(key.info);
  return list;
}

/// Fills an entry from a table. `known` are infos(keys), made once for many entries.
template <class Entry>
void read_entry(const Value& table, const Keys<Entry>& keys, const std::vector<KeyInfo>& known,
                const std::string& where, Entry& entry, Diagnostics& problems) {
  check_keys(table, known, where, table.place, problems);
  for (const Key<Entry>& key : keys)
    if (const Value* value = table.find(key.info.name)) key.read(entry, *value, where, problems);
}

inline constexpr const char* kRequired = "required";

/// A key of which the reader knows everything from the member's type.
template <class Entry, class Base, class Member>
Key<Entry> key(const char* name, Member Base::*member, const char* default_value, const char* unit,
               const char* what, const char* expectation) {
  const bool required = default_value == kRequired;
  KeyInfo info{name, unit, what, expectation, required ? "" : default_value, required};
  return {info,
          [info, member](Entry& entry, const Value& value, const std::string& where, Diagnostics& problems) {
            read_value(info, value, where, entry.*member, problems);
          }};
}
/// A vector that is not 0, kept with length 1.
template <class Entry, class Member>
Key<Entry> direction_key(const char* name, Member Entry::*member, const char* default_value,
                         const char* what) {
  const bool required = default_value == kRequired;
  KeyInfo info{name, "", what, "a direction [x, y, z]", required ? "" : default_value, required};
  return {info,
          [info, member](Entry& entry, const Value& value, const std::string& where, Diagnostics& problems) {
            read_direction(info, value, where, entry.*member, problems);
          }};
}
/// A number, integer or list of numbers with a range.
template <class Entry, class Base, class Member>
Key<Entry> key(const char* name, Member Base::*member, const char* default_value, const char* unit,
               const char* what, const Range& range) {
  const bool required = default_value == kRequired;
  KeyInfo info{name, unit, what, "", required ? "" : default_value, required};
  info.expectation = expectation_of(info, range);
  return {info, [info, member, range](Entry& entry, const Value& value, const std::string& where,
                                      Diagnostics& problems) {
            read_value(info, value, where, range, entry.*member, problems);
          }};
}
template <class Entry>
Key<Entry> choice_key(const char* name, int Entry::*member, const char* default_value, const char* what,
                      const std::vector<std::string>& choices) {
  const bool required = default_value == kRequired;
  KeyInfo info{name, "", what, "one of " + join(choices), required ? "" : default_value, required};
  return {info, [info, member, choices](Entry& entry, const Value& value, const std::string& where,
                                        Diagnostics& problems) {
            read_choice(info, value, where, choices, entry.*member, problems);
          }};
}
template <class Entry>
Key<Entry> words_key(const char* name, std::vector<std::string> Entry::*member, const char* default_value,
                     const char* what, const std::vector<std::string>& choices) {
  KeyInfo info{name, "", what, "an array of words out of " + join(choices), default_value, false};
  return {info, [info, member, choices](Entry& entry, const Value& value, const std::string& where,
                                        Diagnostics& problems) {
            read_words(info, value, where, choices, entry.*member, problems);
          }};
}
template <class Entry>
Key<Entry> mask_key(const char* name, FreeMask Entry::*member, const char* what) {
  KeyInfo info{name, "", what, "a text of some of the letters xyz, \"\" for none", "xyz", false};
  return {info,
          [info, member](Entry& entry, const Value& value, const std::string& where, Diagnostics& problems) {
            read_mask(info, value, where, entry.*member, problems);
          }};
}

}  // namespace feder
