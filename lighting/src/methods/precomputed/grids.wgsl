// The grids of a light.
//
// Needs the parts POINT and SPACE of shadow-dag, and
//   light_baked_words: array<u32>, the words of all grids

const light_MOST_GRIDS: u32 = 6u;

struct light_BakedGrid {
    dag: dag_Shadows,
    space: dag_Space,
}

struct light_Baked {
    grids: array<light_BakedGrid, light_MOST_GRIDS>,
    count: u32,
    // How much farther than half a filter's width points of surfaces are lifted along their
    // normal, in voxels.
    bias: f32,
}

fn dag_word(index: u32) -> u32 {
    return light_baked_words[index];
}
