// Half a disc, the section of a sphere about the axis x = 0 that stands on the plane y = 0 at the origin, finer
// towards the point of contact; with two = 1 another one below.
DefineConstant[
  R = 10,
  near = 0.06,   // cell size at the point of contact,
  radius = 0.6,  // kept within this distance from it,
  growth = 0.12, // then growing by this per length
  gap = 0,       // between sphere and plane
  two = 0
];
For b In {0 : two}
  f = 100 * b;
  up = 1 - 2 * b; // 1: above, -1: below
  Point(f + 1) = {0, up * gap, 0};
  Point(f + 2) = {R, up * (R + gap), 0};
  Point(f + 3) = {0, up * (2 * R + gap), 0};
  Point(f + 4) = {0, up * (R + gap), 0};
  Circle(f + 1) = {f + 1, f + 4, f + 2};
  Circle(f + 2) = {f + 2, f + 4, f + 3};
  Line(f + 3) = {f + 3, f + 4};
  Line(f + 4) = {f + 4, f + 1};
  Curve Loop(f + 1) = {f + 1 : f + 4};
  Plane Surface(f + 1) = {up * (f + 1)};
EndFor
// The lower one is finer by a tenth, so that the meshes do not match.
Field[1] = MathEval;
Field[1].F = Sprintf("(%g + %g * (Sqrt(x*x+y*y) + Fabs(Sqrt(x*x+y*y) - %g) - %g) / 2) * (0.95 + 0.05 * y / (Fabs(y) + 1e-9))", near, growth, radius, radius);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Algorithm = 6;
Recombine Surface "*";
Physical Surface("sphere") = {1};
Physical Curve("round") = {1};
Physical Curve("axis") = {3, 4};
If (two == 1)
  Physical Surface("lower") = {101};
  Physical Curve("lower_round") = {101};
  Physical Curve("lower_axis") = {103, 104};
EndIf
