// A quarter of a sphere that stands on the plane y = 0 at the origin: its lower half (level 0) or all of it, finer
// towards the point of contact. Symmetry planes x = 0 and z = 0.
DefineConstant[
  R = 10,
  near = 0.03,  // cell size at the point of contact,
  radius = 0.25, // kept within this distance from it,
  growth = 0.12, // then growing by this per length
  whole = 0      // 1: with the upper half
];
SetFactory("OpenCASCADE");
top = whole == 1 ? Pi / 2 : 0;
Sphere(1) = {0, 0, 0, R, -Pi / 2, top, Pi / 2};
// The axis of the sphere from z to y, the quarter from x, y > 0 to x, z > 0.
Rotate {{1, 0, 0}, {0, 0, 0}, -Pi / 2} { Volume{1}; }
Translate {0, R, 0} { Volume{1}; }
e = 1e-6 * R;
surfaces[] = Boundary { Volume{1}; };
side[] = Surface In BoundingBox {-e, -e, -R - e, e, 2 * R + e, R + e};
front[] = Surface In BoundingBox {-R - e, -e, -e, R + e, 2 * R + e, e};
cut[] = Surface In BoundingBox {-R - e, R - e, -R - e, R + e, R + e, R + e};
round[] = surfaces[];
round[] -= side[];
round[] -= front[];
round[] -= cut[];
Field[1] = MathEval;
Field[1].F = Sprintf("%g + %g * (Sqrt(x*x+y*y+z*z) + Fabs(Sqrt(x*x+y*y+z*z) - %g) - %g) / 2", near, growth, radius, radius);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Physical Volume("sphere") = {1};
Physical Surface("round") = {round[]};
Physical Surface("side") = {side[]};
Physical Surface("front") = {front[]};
If (whole == 0)
  Physical Surface("cut") = {cut[]};
EndIf
