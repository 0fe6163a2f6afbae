#include "classes.hpp"
#include <algorithm>
#include <filesystem>
#include <impact/input/condition.hpp>
#include <impact/scenario/columns.hpp>

/// The options of what a run writes, -output_<id>_..., -probe_<id>_..., -measure_<id>_..., and of what ends
/// it, -stop_<id>_when.
namespace impact {

namespace {

using Output = OutputScenario;

std::vector<std::string> all_fields() {
  std::vector<std::string> names;
  for (const FieldNote& field : field_notes()) names.emplace_back(field.name);
  return names;
}

template <class List, class Is> bool any(const List& list, Is is) { return std::ranges::any_of(list, is); }

/// All fields that the physics has, but for the acceleration.
std::vector<std::string> usual_fields(const Scenario& s) {
  const bool moves = s.has_motion(), touch = moves && !s.contacts.empty();
  const bool flows = any(s.materials, [](const auto& m) { return m.law.model == Model::j2; });
  const bool rubs = any(s.contacts, [](const auto& c) { return c.friction > 0; });
  std::vector<std::string> fields;
  const auto add = [&](bool there, std::initializer_list<const char*> names) {
    if (there) fields.insert(fields.end(), names.begin(), names.end());
  };
  add(moves, {"u"});
  add(s.has_inertia(), {"v"});
  add(s.has_damage(), {"phi"});
  add(s.has_heat(), {"theta"});
  add(moves, {"stress", "von_mises", "pressure"});
  add(moves && flows, {"alpha"});
  add(s.any_fatigue(), {"fatigue"});
  add(moves && any(s.materials, [](const auto& m) { return PointLaw{m.law}.fails(); }), {"jc_failure"});
  add(any(s.materials, [](const auto& m) { return m.erosion.on; }), {"eroded"});
  add(touch, {"contact_pressure", "contact_gap", "contact_status"});
  add(touch && rubs, {"contact_traction", "contact_slip"});
  return fields;
}

void complete_output(Output& output, const Scenario& scenario) {
  const bool table = output.type == Output::Type::csv;
  if (output.dt == 0 && output.every == 0 && output.cycles == 0 && output.times.empty()) {
    if (table && scenario.explicit_steps())
      output.dt = 1e-3 * scenario.time.max_time;
    else
      output.every = 1;
  }
  if (output.file.empty()) output.file = table ? "history.csv" : output.id + ".xdmf";
  if (!table && output.fields.empty()) output.fields = usual_fields(scenario);
}

/// The first output of a kind, if it is before this one; null: there is none.
template <class Kind> const Output* earlier(const Output& output, const Scenario& s, Kind&& of_kind) {
  const auto first = std::ranges::find_if(s.outputs, of_kind);
  return first != s.outputs.end() && first->id != output.id ? &*first : nullptr;
}

/// The one that writes the same file.
const Output* rival(const Output& output, const Scenario& s) {
  return earlier(output, s, [&](const Output& other) { return other.file == output.file; });
}

/// The history before this one.
const Output* second_history(const Output& output, const Scenario& s) {
  const auto table = [](const Output& other) { return other.type == Output::Type::csv; };
  return table(output) ? earlier(output, s, table) : nullptr;
}

/// Displacements, where nothing else is said.
template <class Struct> void complete_fields(Struct& one, const Scenario&) {
  if (one.fields.empty()) one.fields = {"u"};
}

const std::string about_fields =
    "what is written; contact fields are of its surface, the gap nan beyond its reach";

} // namespace

OptionClass<OutputScenario> output_class() {
  OptionClass<Output> table{
      "output", "outputs", "Output",
      "Without `_dt`, `_every`, `_cycles` and `_times` every accepted step is written. "
      "Of central differences the history has a row for each thousandth of -ts_max_time then (a short stage "
      "after a restart wants a `_dt`).",
      &Scenario::outputs};
  Rows row(table.rows, RestartKey::free);
  row.choice("type", &Output::type, "fields for ParaView, or the history table", "xdmf", Output::Type::xdmf,
             "csv", Output::Type::csv)
      .refused([](const Output& output, const Scenario& s) { return second_history(output, s) != nullptr; },
               [](const Output& output, const Scenario& s) {
                 return "there is one history, and output " + second_history(output, s)->id +
                        " writes it already; remove one of them";
               });
  row.list("fields", &Output::fields, "what an xdmf output holds", all_fields())
      .otherwise("all that the physics has, without a and what materials are told (E, Gc, strength)")
      .barred([](const Output& output) { return output.type == Output::Type::csv; },
              ": has no meaning for type csv; the columns of the history are fixed, use -probes and "
              "-measures");
  row.number("dt", &Output::dt, "s", positive, "written at the first step at or after each multiple");
  row.count("every", &Output::every, 1, "written every so many steps");
  row.count("cycles", &Output::cycles, 1,
            "written in the middle and at the end of every so many cycles of -ts_period")
      .refused([](const Output&, const Scenario& s) { return s.time.period == 0; },
               "counts the cycles of a load whose period is not given; add -ts_period, or remove it");
  row.numbers("times", &Output::times, "s", not_negative, "times that are hit exactly and written");
  row.text("file", &Output::file, "file name", "name below -output_dir")
      .otherwise("<id>.xdmf, history.csv")
      .refused([](const Output& output) { return output.file.front() == '/'; },
               "is an absolute path; allowed: a name below -output_dir")
      .refused(
          [](const Output& output) {
            return std::ranges::any_of(std::filesystem::path(output.file),
                                       [](const auto& part) { return part == ".."; });
          },
          "leads out of its folder; allowed: a name below -output_dir")
      .refused([](const Output& output, const Scenario& s) { return rival(output, s) != nullptr; },
               [](const Output& output, const Scenario& s) {
                 return "is written by output " + rival(output, s)->id + " already; choose another name";
               });
  table.complete = complete_output;
  return table;
}

OptionClass<ProbeScenario> probe_class() {
  using Probe = ProbeScenario;
  OptionClass<Probe> table{"probe", "probes", "Probes",
                           "Values at a material point, as columns `probe_<id>_<field>` of the history.",
                           &Scenario::probes};
  Rows row(table.rows, RestartKey::free);
  row.point("at", &Probe::at, "m", "reference coordinates").required().misfit = [](const Probe& probe,
                                                                                   int dim) {
    return dim == 2 && probe.at[2] != 0 ? "the mesh is in the plane and has no z; allowed: x,y" : "";
  };
  row.text("on", &Probe::region, "name of a region", "region, where two bodies meet")
      .otherwise("any")
      .group_dimension = [](const Probe&, int dim) { return dim; };
  row.list("fields", &Probe::fields, about_fields, all_fields()).otherwise("u");
  table.complete = complete_fields<Probe>;
  return table;
}

OptionClass<MeasureScenario> measure_class() {
  using Measure = MeasureScenario;
  OptionClass<Measure> table{"measure", "measures", "Measures",
                             "Values over a group, as columns `measure_<id>_<field>` of the history.",
                             &Scenario::measures};
  Rows row(table.rows, RestartKey::free);
  row.text("on", &Measure::on, "name of a group", "group of the mesh").required().group_dimension =
      [](const Measure&, int) { return 0; };
  row.list("fields", &Measure::fields, about_fields + "; fields of cells on regions", all_fields())
      .otherwise("u");
  row.choice("of", &Measure::of,
             "what is taken of the values: of those at nodes, which count alike, or of cells, which count by "
             "their reference volume (sum: the integral, in the field's unit times that of volume)",
             "mean", Measure::Of::mean, "min", Measure::Of::min, "max", Measure::Of::max, "sum",
             Measure::Of::sum);
  table.complete = complete_fields<Measure>;
  return table;
}

namespace {

const char* const directions = "x, -x, y, -y, z, -z or a vector, as 1,1,0";

/// An axis, or a vector.
void read_direction(ReleaseScenario& target, const GivenOption& option, const OptionContext&) {
  target.along = option.text;
  double* const e = target.direction;
  std::fill_n(e, 3, 0.0);
  const bool back = option.text.starts_with('-');
  const std::string axis = option.text.substr(back ? 1 : 0);
  if (axis == "x" || axis == "y" || axis == "z")
    e[axis[0] - 'x'] = back ? -1 : 1;
  else {
    const std::vector<std::string> parts = split_list(option.text);
    for (std::size_t k = 0; k < std::min<std::size_t>(parts.size(), 3); ++k)
      e[k] = parse_number(parts[k]).value_or(NAN);
    const double length = std::hypot(e[0], e[1], e[2]);
    if (parts.size() < 2 || parts.size() > 3 || !(length > 0) || !std::isfinite(length))
      refuse_option(option, std::string("no direction; allowed: ") + directions);
    for (int k = 0; k < 3; ++k) e[k] /= length;
  }
}

} // namespace

OptionClass<ReleaseScenario> release_class() {
  using Release = ReleaseScenario;
  const auto on_axis = [](const Release& r, const Scenario& s) {
    return s.plane == PlaneMode::axisymmetric && r.outer >= r.at[0];
  };
  OptionClass<Release> table{
      "release", "releases", "Energy release rates",
      "Of a crack whose tip lies in a ring, as columns `release_<id>` of the history: the elastic energy "
      "that an advance of what the ring encloses would set free, over the area of that advance (of a half "
      "model that half of the energy which is its own). In space the ring is a ball about a point of the "
      "front, which tells the mean along that part of it. It is the rate of elastic energy: J of bodies "
      "that flow only while a small zone has.",
      &Scenario::releases};
  Rows row(table.rows, RestartKey::free);
  row.point("at", &Release::at, "m", "middle of the ring, reference coordinates");
  row.number(
         "inner", &Release::inner, "m (J1)", positive,
         "inner radius, beyond the damage around the tip; about a phase field of length gamma 6 gamma give "
         "0.4 % too little, 4 gamma 2 %")
      .required()
      .needed([](const Release&, const Scenario&) { return true; }, "allowed: a radius > 0");
  row.number("outer", &Release::outer, "m (J1)", positive,
             "outer radius: a circle or ball that meets no other crack, no contact and no held node that the "
             "advance would move out of its plane; sides of the body beyond the inner radius stay where they "
             "are")
      .required()
      .needed([](const Release&, const Scenario&) { return true; }, "allowed: a radius > <>inner")
      .refused([](const Release& r) { return r.outer <= r.inner; },
               "not larger than <>inner {inner}; allowed: > <>inner")
      .refused([](const Release&, const Scenario& s) { return !s.has_motion(); },
               "is for bodies that move; remove -releases")
      .refused(on_axis, "the ring meets the axis; allowed: less than the radius at which <>at is");
  auto& along = row.text("along", &Release::along, directions,
                         "where the crack would advance to; on the command line what begins with a minus "
                         "after a blank, \" -x\"");
  along.read = read_direction;
  along.misfit = [](const Release& r, int dim) {
    return dim == 2 && r.direction[2] != 0 ? ": leaves the plane; allowed: x, -x, y, -y or a vector of it"
                                           : "";
  };
  row.number("length", &Release::length, "m (J1)", positive,
             "length of the front in the ball, each part of it weighted by its advance: the thickness of a "
             "plate within _inner of the point; half of that where a plane of symmetry halves the ball")
      .otherwise("inner + outer, of a straight front")
      .misfit = [](const Release&, int dim) { return dim == 2 ? ": of fronts in space; remove it" : ""; };
  return table;
}

OptionClass<StopScenario> stop_class() {
  OptionClass<StopScenario> table{
      "stop", "stops", "Stops",
      "A run ends with exit status 0, a checkpoint and its last output when one of these holds at the end of "
      "a step. `peak(x)` is the largest value that x has had since t = 0, for any x; t is the time, `&&` and "
      "`||` join comparisons.",
      &Scenario::stops};
  Rows(table.rows, RestartKey::free)
      .text("when", &StopScenario::when, "condition on columns by name",
            "what ends the run, as in reaction_top_y < 0.1*peak(reaction_top_y): an expression of columns of "
            "the history and of parameters")
      .required();
  // Columns are known when the run starts, the grammar is now.
  table.finish = [](const StopScenario& stop, OptionContext& context) {
    const std::string key = "-stop_" + stop.id + "_when";
    Condition(key, stop.when, context.names.parameters);
    if (stop.when.find_first_of("<>=") == std::string::npos)
      refuse_option({key, stop.when}, "compares nothing; allowed: comparisons, as in reaction_top_y < 0.1");
  };
  return table;
}

} // namespace impact
