// The grids of the current light. Needs light_number() and the variable
//   light_baked_lights: array<light_Baked>

fn light_baked_count() -> u32 {
    return light_baked_lights[light_number()].count;
}

fn light_baked_grid(grid: u32) -> light_BakedGrid {
    return light_baked_lights[light_number()].grids[grid];
}
