// The grids of one light. Needs the variable
//   light_baked: light_Baked

fn light_baked_count() -> u32 {
    return light_baked.count;
}

fn light_baked_grid(grid: u32) -> light_BakedGrid {
    return light_baked.grids[grid];
}
