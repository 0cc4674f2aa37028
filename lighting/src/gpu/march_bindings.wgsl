// Steps of a march when this crate assembles the shader. Needs map_faces.wgsl.

fn light_march_samples() -> u32 {
    return map.samples;
}

fn light_march_is_equi_angular() -> bool {
    return map.equi_angular != 0u;
}
