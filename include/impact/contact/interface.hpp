#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <impact/contact/node_exchange.hpp>
#include <impact/contact/search.hpp>
#include <impact/contact/settings.hpp>
#include <impact/contact/surface.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/mesh/state_table.hpp>
#include <string>
#include <utility>
#include <vector>

/// One contact between two surfaces in the plane, frictionless, integrated at points of the secondary facets
/// (Gauss-point segment-to-segment): R_c(w) = -int p dg[w] dA_0 with p = <lambda - eps g> over the reference
/// area (theory.md, contact). The force at a displacement depends on the multipliers, the penalty, the
/// candidate list and the primary edges that points near the surface are held to: nothing is stored by an
/// evaluation. Multipliers and penalty are rows of the state table; evaluations read the trial half.
///
/// Where the surface has a kink, the nearest edge changes from one side of a vertex to the other and with it
/// the direction of the force, so that Newton's method may jump to and fro. update_search therefore ties
/// every point near the surface to its edge, continued straight beyond the ends, until the next call, and
/// lets go only when the point has left the edge by more than an overlap. The tie begins afresh with every
/// attempt of a step (set_time), so it is no state.
namespace impact {

/// What the caller knows and the user's settings do not say.
struct ContactEnvironment {
  Frame frame = Frame::plane_strain;
  double thickness = 1; ///< multiplies what is reported of plane problems
  double modulus = 0;   ///< Young's modulus of the softer undegraded side
  double density = 0;   ///< of the heaviest side where bodies have inertia, else 0
  double length = 0;    ///< cell size beside the surface; 0: mean secondary facet
  std::function<std::array<double, 2>(double)>
      plane_motion; ///< displacement of the rigid plane; empty: at rest
};

/// A secondary point that faces something, at one displacement: the list that every consumer walks.
struct ContactPoint {
  int facet = 0, index = 0;        ///< secondary facet of this rank; facet * points + point
  int node_count = 4;              ///< 4, or 2 against the rigid plane
  std::array<int, 4> node{};       ///< into the interface's own node list: secondary 0, 1, primary 0, 1
  std::array<double, 2> shape{};   ///< secondary shape functions
  double weight = 0, stretch = 1;  ///< reference area (see SurfacePoints); current over reference area
  double lambda = 0, pressure = 0; ///< nominal
  Foot<double> foot;
  PrimaryEdge<double> edge;
};

/// What an evaluation saw, on this rank, without a reduction.
struct ContactStatus {
  int active = 0;           ///< points with p > 0
  double penetration = 0;   ///< largest -g
  bool finite = true;       ///< false: a coordinate is not a number
  bool search_holds = true; ///< false: something moved so far that the candidate list may miss a facet
};

/// What an augmentation changes; equal on all ranks.
struct AugmentReport {
  double penetration = 0; ///< max(-g) over all points
  double largest_gap = 0; ///< max of |g|, at most p / eps, over the points with p > 0
  double multiplier = 0;  ///< largest new multiplier
  double change = 0;      ///< largest change of a multiplier over the largest new one
  double penalty = 0;     ///< the penalty that was used
  int active = 0;
  bool settled = true; ///< no point changed its edge since the solve, none is deeper than the search radius
  /// settled, and unless the penalty is all: penetration < gap_tol and change < pressure_tol
  bool converged = false;
};

/// For the history file. Totals count from t = 0. Plane problems: times the thickness; axisymmetric: the full
/// ring.
struct ContactMeasures {
  std::array<double, 2> force{};   ///< on the secondary side
  double gap_min = 0;              ///< nan when no point faces anything
  double pressure_max = 0;         ///< per current area
  double pressure_min = 0;         ///< over the active points, 0 without
  double length = 0;               ///< closed part of the secondary surface, current length or ring area
  double energy = 0;               ///< potential (p^2 - lambda^2) / (2 eps)
  double work = 0;                 ///< done by the contact forces on the bodies, total
  std::array<double, 2> impulse{}; ///< on the secondary side, total
  int active = 0;
};

/// Overlap of the undeformed surfaces at the secondary nodes.
struct InitialOverlapReport {
  int nodes = 0;             ///< nodes that must be moved (setting adjust), over all ranks
  double deepest = 0;        ///< largest overlap found
  std::vector<double> shift; ///< [local node][2] stress-free shift of reference coordinates, ghosts included
};

class ContactInterface {
public:
  /// Mesh and layout must outlive the interface; rows `contact_<id>_multiplier`, `_penalty`, `_totals`,
  /// `_force` are added to the table, and the candidates at u = 0 are found. Throws UserError: unknown or
  /// equal groups, a penalty that is not positive, automatic without a modulus, a plane without a normal.
  /// Collective.
  ContactInterface(const Mesh& mesh, const FieldLayout& displacement, const ContactSettings& settings,
                   const ContactEnvironment& environment, StateTable& state);

  const std::string& id() const { return settings_.id; }
  /// Settings with every automatic value replaced by its number.
  const ContactSettings& settings() const { return settings_; }
  /// Sentences for the user: primary facets shorter than the spacing of the points. Equal on all ranks.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Beginning of an attempt that ends at t: where the rigid plane's motion is taken. Points are tied to no
  /// edge, and the committed row `u` of the table, where there is one, says where they start. `mass_shift`
  /// (1/s^2) is the factor of the mass in the tangent, 0 without inertia: an automatic penalty of an
  /// augmented Lagrangian is raised to 2.5 rho h mass_shift for the attempt. Collective.
  void set_time(double t, double mass_shift = 0);
  /// Local dofs [node * 2 + k] whose rows and columns tangent and multiply leave out; the residual keeps
  /// them, for the reactions. Flags of remote nodes are fetched here and when the candidates change.
  /// Collective.
  void set_fixed_dofs(const std::vector<char>& fixed);

  /// Brings the candidate list up to date when a node moved more than half the skin, or farther since the
  /// start of the step than the list reaches, and ties the points near the surface to their edges; true on
  /// all ranks when the set of pairs, hence the matrix pattern, changed. Collective: one reduction when
  /// nothing moved that far.
  bool update_search(Vec u);
  /// The next update_search builds the list afresh, as a restarted run does.
  void forget_search() { search_.outdated = true; }
  /// Pairs of global nodes that the candidates of this rank may couple, sorted, each once.
  std::vector<std::pair<PetscInt, PetscInt>> couplings() const;

  /// r += scale f, f = -int p dg dA_0 (a residual: minus the force on the bodies). Collective.
  ContactStatus add_residual(Vec u, double scale, Vec r) const;
  /// K += scale df/du by MatSetValues; the caller assembles. Symmetric. Collective.
  ContactStatus add_tangent(Vec u, double scale, Mat K) const;
  /// y += scale (df/du) du without a matrix. Collective.
  void multiply(Vec u, double scale, Vec du, Vec y) const;

  /// Forgets the gap that the penalty rule compares with: first call of each Uzawa loop.
  void start_augmentation();
  /// What augment would do, without doing it. Collective.
  AugmentReport review(Vec u) const;
  /// lambda <- <lambda - eps g> at every secondary point, 0 where it faces nothing, then the penalty grows by
  /// its rule. Pure penalty: nothing changes. Collective.
  AugmentReport augment(Vec u);

  /// After an accepted step: impulse and work of the step by the trapezoidal rule into the trial totals. A
  /// call with u_n = u and dt = 0 before the first step records the force of the start. Collective.
  void advance(Vec u_n, Vec u, double dt);
  /// Collective.
  ContactMeasures measures(Vec u) const;
  /// Pressure (per current area, 0 off the surface) and gap (nan where nothing is near) at the secondary
  /// nodes as weighted means of the points, [local node], ghosts included. Collective.
  void nodal_fields(Vec u, std::vector<double>& pressure, std::vector<double>& gap) const;

  /// Overlap at u = 0. Throws UserError(data) when it is forbidden (setting error) or deeper than initial_tol
  /// (adjust); overlap of rounding size counts as none. The shift is not applied. Collective.
  InitialOverlapReport initial_overlap();

private:
  double penalty() const { return std::max(penalty_->trial[0], penalty_->trial[2]); }
  struct Side {
    ContactSurface surface;
    std::vector<PetscInt> neighbour; // [facet][2]
    std::vector<int> slot;           // [facet][2] into the static node list
  };
  struct Search {
    NodeExchange own;                // static: nodes of this rank's facets of both surfaces
    std::vector<PetscInt> own_nodes; // sorted global nodes
    std::vector<double> own_X;       // [node][2]
    std::vector<double> built_at;    // current coordinates of own_nodes when the list was built
    std::vector<double> start;       // coordinates of own_nodes at the start of the step; empty: unknown
    bool outdated = true;
    double radius = 0, skin = 0;
    double reach = 0; // the list holds every facet so near: the radius, or the motion of the step if larger
    Candidates candidates;
  };
  // Everything that evaluations need, on compact numbers: own secondary nodes, candidate primary nodes, their
  // neighbours.
  struct Active {
    NodeExchange exchange;
    std::vector<PetscInt> nodes;     // sorted global nodes
    std::vector<double> X, built_at; // [node][2]
    std::vector<double> start;       // [node][2] at the start of the step; empty: unknown
    std::vector<int> secondary;      // [facet][2]
    std::vector<int> primary;        // [primary][4]: node 0, node 1, neighbours (-1 at an end)
    std::vector<char> fixed;         // [node][2]
  };

  // The edge, by its global nodes, that a point is tied to.
  struct Hold {
    std::array<PetscInt, 2> edge = {-1, -1};
    int switches = 0; // in this attempt, while it carried a pressure
  };

  void set_automatic_values();
  void build_search_nodes();
  void declare_state(StateTable& state);
  Candidates search(const std::vector<double>& x) const;
  void build_active(Vec u);
  void fetch_fixed();
  void fetch_start();
  void hold_edges(const std::vector<double>& x);
  bool against_plane() const { return settings_.primary == "plane"; }

  std::vector<double> current(Vec u) const; // [node][2] of active_.nodes
  std::vector<ContactPoint> points(Vec u, ContactStatus* status) const;
  // The foot on the edge's line once more, from differences of X and of u: those of x = X + u lose what the
  // displacements are smaller than the coordinates, and a penalty makes a pressure of it.
  void sharpen(const std::vector<double>& u, ContactPoint& point) const;
  Foot<double> plane_foot(const Point2<double>& x) const;
  // What the point at x faces: its held edge, else the nearest, else one that it passed in this step.
  bool face(const Point2<double>& x, const Point2<double>& normal, const std::vector<double>& coordinates,
            const Hold& hold, ContactPoint& point) const;
  bool face_nearest(const Point2<double>& x, const Point2<double>& normal,
                    const std::vector<double>& coordinates, ContactPoint& point) const;
  bool face_held(const Point2<double>& x, const Point2<double>& normal,
                 const std::vector<double>& coordinates, const Hold& hold, ContactPoint& point) const;
  bool face_passed(const Point2<double>& x, const Point2<double>& normal,
                   const std::vector<double>& coordinates, ContactPoint& point) const;
  PrimaryEdge<double> primary_edge(int candidate, const std::vector<double>& coordinates) const;
  AugmentReport propose(Vec u, std::vector<double>& lambda) const;

  const Mesh* mesh_;
  const FieldLayout* layout_;
  const StateTable* state_;
  ContactSettings settings_;
  ContactEnvironment environment_;
  std::vector<std::string> warnings_;
  Side secondary_, primary_;
  SurfacePoints points_;
  Search search_;
  Active active_;
  std::vector<Hold> holds_; // [secondary facet][point]
  double hold_gap_ = 0;     // by which a held edge's gap may differ from the nearest edge's
  bool switched_ = false;   // the last update_search changed what a point with pressure faces, on this rank
  Handle<Vec> fixed_;       // 1 at fixed dofs; absent: none
  StateRow *multiplier_, *penalty_, *totals_, *force_;
  double inertia_penalty_ = 0; // over the mass shift
  double time_ = 0;
};

} // namespace impact
