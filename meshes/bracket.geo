// A bracket: a base with two bolt holes, an upright with a pin hole, a fillet between them. Tetrahedra, smaller in the
// fillet. The group "bolts" is the bore of both bolt holes, "pin" that of the pin hole, "foot" the base's lower side.
SetFactory("OpenCASCADE");
DefineConstant[
  width = 40, reach = 30, height = 36, wall = 6, // of the bracket: along y, x, z, and of both plates
  fillet = 5, bolt = 3.5, pin = 5,               // radii
  h = 1.5,                                       // of cells in the fillet
  coarse = 3
];
Box(1) = {0, 0, 0, reach, width, wall};
Box(2) = {0, 0, 0, wall, width, height};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
near = 0.01;
inner[] = Curve In BoundingBox {wall - near, -near, wall - near, wall + near, width + near, wall + near};
body[] = Fillet{3}{inner[]}{fillet};
Cylinder(11) = {20, width / 4, -1, 0, 0, wall + 2, bolt};
Cylinder(12) = {20, 3 * width / 4, -1, 0, 0, wall + 2, bolt};
Cylinder(13) = {-1, width / 2, height - 10, wall + 2, 0, 0, pin};
BooleanDifference(20) = { Volume{body[0]}; Delete; }{ Volume{11, 12, 13}; Delete; };

first[] = Surface In BoundingBox {20 - bolt - near, width / 4 - bolt - near, -near, 20 + bolt + near, width / 4 + bolt + near, wall + near};
second[] = Surface In BoundingBox {20 - bolt - near, 3 * width / 4 - bolt - near, -near, 20 + bolt + near, 3 * width / 4 + bolt + near, wall + near};
bore[] = Surface In BoundingBox {-near, width / 2 - pin - near, height - 10 - pin - near, wall + near, width / 2 + pin + near, height - 10 + pin + near};
under[] = Surface In BoundingBox {-near, -near, -near, reach + near, width + near, near};
Physical Surface("bolts") = {first[], second[]};
Physical Surface("pin") = {bore[]};
Physical Surface("foot") = {under[]};
Physical Volume("bracket") = {20};

// Cells grow with the distance from the box around the upright's root, where the bracket bends most.
Field[1] = Box;
Field[1].VIn = h;
Field[1].VOut = coarse;
Field[1].XMin = -1; Field[1].XMax = wall + 1;
Field[1].YMin = -1; Field[1].YMax = width + 1;
Field[1].ZMin = wall + 1; Field[1].ZMax = wall + fillet + 3;
Field[1].Thickness = 6;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
