// The notched beam of beam_wedge.geo without the wedge; the point `tip`, (5, 0) mm, is where the wedge would touch.
// -mesh_set_h_notch, _h_far, _h_under, _h_factor are passed on.
DefineConstant[ wedge = 0 ];
Include "beam_wedge.geo";
