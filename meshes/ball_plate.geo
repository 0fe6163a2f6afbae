// A ball above the middle of a square plate: tetrahedra, fine along the surface below, and layers of hexahedra. The plate's
// upper side is z = 0.
DefineConstant[
  radius = 30, gap = 1, // of the ball, from the plate
  near = 4, far = 12,   // sizes of its cells at the lowest point and at the highest
  width = 200, thick = 10, n = 20, layers = 2
];
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, gap + radius, radius};
Rectangle(100) = {-width / 2, -width / 2, -thick, width, width};
edges[] = Boundary { Surface{100}; };
Transfinite Curve {edges[]} = n + 1;
Transfinite Surface {100};
Recombine Surface {100};
plate[] = Extrude {0, 0, thick} { Surface{100}; Layers{layers}; Recombine; };
ball[] = Boundary { Volume{1}; };
Field[1] = MathEval;
Field[1].F = Sprintf("%g + (%g) * (Fabs(z - %g) + z - %g) / %g", near, far - near, gap, gap, 4 * radius);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Physical Volume("ball") = {1};
Physical Surface("ball_side") = {ball[]};
Physical Volume("plate") = {plate[1]};
Physical Surface("plate_top") = {plate[0]};
Physical Surface("plate_bottom") = {100};
Physical Surface("plate_edges") = {plate[2], plate[3], plate[4], plate[5]};
