#include <array>
#include <cstddef>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <petsclog.h>

namespace impact {

namespace {

// In the order of the enumerations.
constexpr std::array stage_names = {"Set-up", "Steps", "Motion", "Damage", "Heat", "Output"};
constexpr std::array event_names = {
    "MeshGmsh",       "MeshRead",      "MeshBuild",    "MeshPartition",   "MotionResidual", "MotionTangent",
    "MotionMatrix",   "MotionPoints",  "MotionForces", "ContactSearch",   "ContactForces",  "ContactTangent",
    "DamageResidual", "DamageTangent", "DamagePoints", "HeatResidual",    "HeatTangent",    "HeatLoads",
    "Balances",       "History",       "FieldOutput",  "CheckpointWrite", "CheckpointRead"};
static_assert(stage_names.size() == static_cast<std::size_t>(Stage::output) + 1);
static_assert(event_names.size() == static_cast<std::size_t>(Event::checkpoint_read) + 1);

struct Registered {
  std::array<PetscLogStage, stage_names.size()> stage;
  std::array<PetscLogEvent, event_names.size()> event;

  Registered() {
    PetscClassId id = 0;
    check(PetscClassIdRegister("impact", &id));
    for (std::size_t i = 0; i < stage.size(); ++i) check(PetscLogStageRegister(stage_names[i], &stage[i]));
    for (std::size_t i = 0; i < event.size(); ++i)
      check(PetscLogEventRegister(event_names[i], id, &event[i]));
  }
};

const Registered& registered() {
  static const Registered once;
  return once;
}

} // namespace

InStage::InStage(Stage stage) {
  check(PetscLogStagePush(registered().stage[static_cast<std::size_t>(stage)]));
}

InStage::~InStage() { PetscLogStagePop(); }

Timed::Timed(Event event) : id_(registered().event[static_cast<std::size_t>(event)]) {
  check(PetscLogEventBegin(id_, nullptr, nullptr, nullptr, nullptr));
}

Timed::~Timed() { PetscLogEventEnd(id_, nullptr, nullptr, nullptr, nullptr); }

} // namespace impact
