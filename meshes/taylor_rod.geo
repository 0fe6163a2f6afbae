// A quarter of a round bar, the axis along z; the end that hits at z = 0. Hexahedra: a square with rounded sides inside, two
// blocks around it.
DefineConstant[
  radius = 3.2, length = 32.4,
  n = 6, layers = 60 // cells along a side of the blocks, along the axis
];
a = 0.5 * radius; b = 0.42 * radius; c = radius / Sqrt(2);
Point(1) = {0, 0, 0}; Point(2) = {a, 0, 0}; Point(3) = {b, b, 0}; Point(4) = {0, a, 0};
Point(5) = {radius, 0, 0}; Point(6) = {c, c, 0}; Point(7) = {0, radius, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {2, 5}; Circle(6) = {5, 1, 6}; Line(7) = {6, 3};
Circle(8) = {6, 1, 7}; Line(9) = {7, 4};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Curve Loop(2) = {5, 6, 7, -2}; Plane Surface(2) = {2};
Curve Loop(3) = {-7, 8, 9, -3}; Plane Surface(3) = {3};
Transfinite Curve {1 : 9} = n + 1;
Transfinite Surface {1 : 3}; Recombine Surface {1 : 3};
block1[] = Extrude {0, 0, length} { Surface{1}; Layers{layers}; Recombine; };
block2[] = Extrude {0, 0, length} { Surface{2}; Layers{layers}; Recombine; };
block3[] = Extrude {0, 0, length} { Surface{3}; Layers{layers}; Recombine; };
Physical Volume("bar") = {block1[1], block2[1], block3[1]};
Physical Surface("foot") = {1, 2, 3};
Physical Surface("tail") = {block1[0], block2[0], block3[0]};
Physical Surface("across_y") = {block1[2], block2[2]};
Physical Surface("across_x") = {block1[5], block3[4]};
Physical Surface("skin") = {block2[3], block3[3]};
