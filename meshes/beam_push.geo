// The beam of beam_wedge.geo alone, short and with a shallow slit: [0,6] x [0,2] mm. The point `tip` is (5, 0).
DefineConstant[
  length = 6,
  height = 2,
  notch = 1,
  depth = 0.375,
  touch = 5,
  band = 0.875,
  h_far = 0.25,
  h_left = 0.125,
  h_under = 0.125,
  wedge = 0
];
Include "beam_wedge.geo";
