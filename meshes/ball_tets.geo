// A ball above the middle of a square plate whose upper side is z = 0, both of tetrahedra, mm.
DefineConstant[
  radius = 5, gap = 0.3, // of the ball, from the plate
  width = 40, thick = 3,
  h = 1.5, far = 3       // sizes of cells beside the axis and at the edges
];
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, radius + gap, radius};
Box(2) = {-width / 2, -width / 2, -thick, width, width, thick};
Physical Volume("ball") = {1};
Physical Volume("plate") = {2};
skin[] = Boundary { Volume{1}; };
Physical Surface("ball_side") = {skin[]};
sides[] = Boundary { Volume{2}; };
e = 1e-3;
top[] = Surface In BoundingBox {-width, -width, -e, width, width, e};
bottom[] = Surface In BoundingBox {-width, -width, -thick - e, width, width, -thick + e};
sides[] -= {top[], bottom[]};
Physical Surface("plate_top") = {top[]};
Physical Surface("plate_bottom") = {bottom[]};
Physical Surface("plate_edges") = {sides[]};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + %g * (Fabs(Sqrt(x*x + y*y) - 6) + Sqrt(x*x + y*y) - 6) / 2", h, (far - h) / 14);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
