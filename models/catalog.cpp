#include "models/catalog.h"

#include <algorithm>

#include "engine/check.h"
#include "models/asymmetric_top.h"
#include "models/bath.h"
#include "models/bending_rod.h"
#include "models/bouncing_ball.h"
#include "models/chain.h"
#include "models/cloth.h"
#include "models/cloth_drop.h"
#include "models/cradle.h"
#include "models/dam_break.h"
#include "models/damped_oscillator.h"
#include "models/double_pendulum.h"
#include "models/drop.h"
#include "models/flexible_linkage.h"
#include "models/floating_body.h"
#include "models/four_bar.h"
#include "models/hanging_chain.h"
#include "models/heavy_top.h"
#include "models/hydrostatic_column.h"
#include "models/incline.h"
#include "models/ladder.h"
#include "models/lattice.h"
#include "models/mesh_collision.h"
#include "models/n_pendulum.h"
#include "models/oscillator.h"
#include "models/parameters.h"
#include "models/pendulum.h"
#include "models/plate_bridge.h"
#include "models/plate_net.h"
#include "models/rigid_chain.h"
#include "models/robot_arm.h"
#include "models/rolling_ball.h"
#include "models/slider_crank.h"
#include "models/spring_pendulum.h"
#include "models/stack.h"
#include "models/taut_string.h"

namespace feder {

// THE LIST.
const std::vector<ModelInfo>& catalog() {
  static const std::vector<ModelInfo> list = {
      oscillator_model(),
      damped_oscillator_model(),
      pendulum_model(),
      spring_pendulum_model(),
      chain_model(),
      hanging_chain_model(),
      taut_string_model(),
      bending_rod_model(),
      cloth_model(),
      lattice_model(),
      asymmetric_top_model(),
      rigid_chain_model(),
      plate_bridge_model(),
      plate_net_model(),
      heavy_top_model(),
      double_pendulum_model(),
      n_pendulum_model(),
      four_bar_model(),
      slider_crank_model(),
      flexible_linkage_model(),
      incline_model(),
      rolling_ball_model(),
      ladder_model(),
      stack_model(),
      drop_model(),
      bouncing_ball_model(),
      cradle_model(),
      cloth_drop_model(),
      mesh_collision_model(),
      robot_arm_model(),
      hydrostatic_column_model(),
      dam_break_model(),
      floating_body_model(),
      bath_model(),
  };
  return list;
}

namespace {

// What a spec asks for.
struct Request {
  const ModelInfo* info = nullptr;
  Settings settings;
};

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// What stands between the commas; at least one word, which may be empty.
std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> list;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    list.push_back(trimmed(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return list;
}

// "key=value,key=value"; every key once.
Settings parse_settings(const std::string& place, const std::string& text) {
  Settings settings;
  for (const std::string& part : words(text)) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw InputError(place + ": setting " + quoted(part) + ", expected key=value");
    const Setting setting{trimmed(part.substr(0, equals)), trimmed(part.substr(equals + 1))};
    for (const Setting& earlier : settings)
      if (earlier.key == setting.key)
        throw InputError(place + ": parameter " + quoted(setting.key) + " given twice, expected once");
    settings.push_back(setting);
  }
  return settings;
}

std::string written(const Preset& preset) {
  return preset.name + "(" + preset.arguments + ")";
}

[[noreturn]] void fail_sizes(const std::string& head, const Preset& preset) {
  std::string example = preset.name + "(";
  for (std::size_t i = 0; i < words(preset.arguments).size(); ++i) example += "10,";
  example.back() = ')';
  throw InputError("preset " + quoted(head) + ": expected " + written(preset) + ", for example " + example);
}

[[noreturn]] void fail_unknown_model(const std::string& head, const std::string& name) {
  std::vector<std::string> models, presets, all;
  for (const ModelInfo& info : catalog()) {
    models.push_back(info.name);
    all.push_back(info.name);
    for (const Preset& preset : info.presets) {
      presets.push_back(written(preset));
      all.push_back(preset.name);
    }
  }
  throw InputError("model " + quoted(head) + ": unknown, did you mean '" + nearest(name, all) +
                   "'? Models: " + join(models) + "; presets: " + join(presets));
}

// The part before the colon: a model, or a preset with its sizes in brackets.
Request find_model(const std::string& head) {
  const std::size_t bracket = head.find('(');
  const std::string name = trimmed(head.substr(0, bracket));
  for (const ModelInfo& info : catalog()) {
    if (bracket == std::string::npos && info.name == name) return {&info, {}};
    for (const Preset& preset : info.presets) {
      if (preset.name != name) continue;
      if (bracket == std::string::npos || head.back() != ')') fail_sizes(head, preset);
      const std::vector<std::string> names = words(preset.arguments),
                                     sizes = words(head.substr(bracket + 1, head.size() - bracket - 2));
      if (sizes.size() != names.size()) fail_sizes(head, preset);
      Request request{&info, preset.fixed};
      for (std::size_t i = 0; i < names.size(); ++i) request.settings.push_back({names[i], sizes[i]});
      return request;
    }
  }
  fail_unknown_model(head, name);
}

}  // namespace

Model make_model(const std::string& spec) {
  const std::size_t colon = spec.find(':');
  Request request = find_model(trimmed(spec.substr(0, colon)));
  if (colon != std::string::npos)
    for (const Setting& setting : parse_settings("model " + request.info->name, spec.substr(colon + 1)))
      request.settings.push_back(setting);
  Model model = request.info->build(request.settings);
  // numbers good one by one may still overflow together
  require_positive("model " + request.info->name, "end time", model.end_time, "s");
  require_positive("model " + request.info->name, "scene length", model.scene_length, "m");
  model.name = spec;
  return model;
}

}  // namespace feder
