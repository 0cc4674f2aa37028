// A shadow map as what voxelized shadow volumes are made from. Needs MAP.

fn vsv_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return light_first_blocker(origin, direction);
}
