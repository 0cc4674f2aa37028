// A part of a path that the light reaches. A visibility source defines
//   struct light_Look                      its state along one ray
//   fn light_look(path: light_Path) -> light_Look
//   fn light_next_lit(look: ptr<function, light_Look>, path: light_Path) -> light_Lit
// and yields the lit parts of the path in order, then one of visibility 0.

struct light_Lit {
    start: f32,
    end: f32,
    visibility: f32,
}
