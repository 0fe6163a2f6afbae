// Two blocks that fill the unit square or cube between them, on an interface of inclined planes (strips) through points of
// y = middle + slope x + tilt z + the cap of a circle of the given radius. Their meshes do not match: as many strips, with
// other cells on each, or, with other numbers of strips, other polygons through the same curve.
DefineConstant[
  dim = 3,                                    // 2 or 3
  strips_lower = 3, strips_upper = 3,         // planes of the interface
  n_lower = 1, n_upper = 2,                   // cells along a strip
  m_lower = 3, m_upper = 2,                   // cells up each block, and in z
  middle = 0.45, slope = 0.1, tilt = 0.15,
  radius = 0,                                 // 0: no cap
  simplices_lower = 0, simplices_upper = 0    // 1: triangles or tetrahedra
];
strips[] = {strips_lower, strips_upper};
n[] = {n_lower, n_upper};
m[] = {m_lower, m_upper};
simplices[] = {simplices_lower, simplices_upper};
sides = dim - 1; // of each block in z
For b In {0 : 1}
  f = 10000 * b; // numbers of this block start here
  q = strips[b];
  volumes[] = {}; faces[] = {}; ends[] = {}; outside[] = {}; left[] = {}; right[] = {}; front[] = {};
  For k In {0 : q}
    x = k / q;
    cap = radius > 0 ? Sqrt(radius^2 - (x - 0.5)^2) - Sqrt(radius^2 - 0.25) : 0;
    For s In {0 : sides - 1}
      // Level 0 is outside, level 1 the interface.
      Point(f + 4 * k + 2 * s + 1) = {x, b, s};
      Point(f + 4 * k + 2 * s + 2) = {x, middle + slope * x + tilt * s + cap, s};
      Line(f + 1000 + 2 * k + s) = {f + 4 * k + 2 * s + 1, f + 4 * k + 2 * s + 2};
      Transfinite Curve {f + 1000 + 2 * k + s} = m[b] + 1;
      If (k > 0)
        For level In {0 : 1}
          Line(f + 2000 + 4 * k + 2 * s + level) = {f + 4 * (k - 1) + 2 * s + level + 1, f + 4 * k + 2 * s + level + 1};
          Transfinite Curve {f + 2000 + 4 * k + 2 * s + level} = n[b] + 1;
        EndFor
      EndIf
    EndFor
    If (dim == 3)
      For level In {0 : 1}
        Line(f + 3000 + 2 * k + level) = {f + 4 * k + level + 1, f + 4 * k + level + 3};
        Transfinite Curve {f + 3000 + 2 * k + level} = m[b] + 1;
      EndFor
      Curve Loop(f + 3000 + k) = {f + 3000 + 2 * k, f + 1000 + 2 * k + 1, -(f + 3000 + 2 * k + 1), -(f + 1000 + 2 * k)};
      Plane Surface(f + 3000 + k) = {f + 3000 + k};
    EndIf
    If (k > 0)
      For s In {0 : sides - 1}
        Curve Loop(f + 1000 + 2 * k + s) = {f + 2000 + 4 * k + 2 * s, f + 1000 + 2 * k + s, -(f + 2000 + 4 * k + 2 * s + 1),
                                            -(f + 1000 + 2 * (k - 1) + s)};
        Plane Surface(f + 1000 + 2 * k + s) = {f + 1000 + 2 * k + s};
        ends[] += {f + 1000 + 2 * k + s};
      EndFor
      If (dim == 3)
        For level In {0 : 1}
          Curve Loop(f + 2000 + 2 * k + level) = {f + 2000 + 4 * k + level, f + 3000 + 2 * k + level,
                                                  -(f + 2000 + 4 * k + 2 + level), -(f + 3000 + 2 * (k - 1) + level)};
          Plane Surface(f + 2000 + 2 * k + level) = {f + 2000 + 2 * k + level};
        EndFor
        outside[] += {f + 2000 + 2 * k};
        faces[] += {f + 2000 + 2 * k + 1};
        Surface Loop(f + k) = {f + 1000 + 2 * k, f + 1000 + 2 * k + 1, f + 2000 + 2 * k, f + 2000 + 2 * k + 1,
                               f + 3000 + k - 1, f + 3000 + k};
        Volume(f + k) = {f + k};
        volumes[] += {f + k};
        front[] += {f + 1000 + 2 * k + 1};
        left[] += {f + 1000 + 2 * k};
      Else
        outside[] += {f + 2000 + 4 * k};
        faces[] += {f + 2000 + 4 * k + 1};
      EndIf
    EndIf
  EndFor
  If (dim == 3)
    Physical Volume(Sprintf("body_%g", b)) = {volumes[]};
    Physical Surface(Sprintf("face_%g", b)) = {faces[]};
    Physical Surface(Sprintf("outside_%g", b)) = {outside[]};
    Physical Surface(Sprintf("x0_%g", b)) = {f + 3000};
    Physical Surface(Sprintf("x1_%g", b)) = {f + 3000 + q};
    Physical Surface(Sprintf("z0_%g", b)) = {left[]};
    Physical Surface(Sprintf("z1_%g", b)) = {front[]};
  Else
    Physical Surface(Sprintf("body_%g", b)) = {ends[]};
    Physical Curve(Sprintf("face_%g", b)) = {faces[]};
    Physical Curve(Sprintf("outside_%g", b)) = {outside[]};
    Physical Curve(Sprintf("x0_%g", b)) = {f + 1000};
    Physical Curve(Sprintf("x1_%g", b)) = {f + 1000 + 2 * q};
  EndIf
  Transfinite Surface "*";
  If (simplices[b] == 0)
    Recombine Surface {ends[]};
    If (dim == 3)
      Recombine Surface {outside[], faces[], f + 3000 : f + 3000 + q};
      Transfinite Volume {volumes[]};
    EndIf
  EndIf
EndFor
