// Where precomputed voxelized shadows are found when this crate assembles the shader.

struct BakedGrid {
    dag: dag_Shadows,
    space: dag_Space,
}

struct Baked {
    grids: array<BakedGrid, light_MOST_GRIDS>,
    count: u32,
}

@group(1) @binding(0) var<uniform> baked: Baked;
@group(1) @binding(1) var<storage> words: array<u32>;

fn dag_word(index: u32) -> u32 {
    return words[index];
}

fn light_dag_grids() -> u32 {
    return baked.count;
}

fn light_dag_shadows(grid: u32) -> dag_Shadows {
    return baked.grids[grid].dag;
}

fn light_dag_space(grid: u32) -> dag_Space {
    return baked.grids[grid].space;
}
