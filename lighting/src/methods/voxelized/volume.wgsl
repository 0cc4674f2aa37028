// The voxels of one light: what voxels.wgsl reads.
//
// Needs the variables
//   light_voxel_volume: light_Voxels
//   light_voxel_bounds: array<vec2<f32>>, the bounds of the lattice along φ
//   light_voxel_words: array<u32>, the words of the grid

fn light_voxels() -> light_Voxels {
    return light_voxel_volume;
}

fn epi_bound(index: u32) -> vec2<f32> {
    return light_voxel_bounds[index];
}

fn vsv_word(index: u32) -> u32 {
    return light_voxel_words[index];
}
