// Questions to a map between its texel centres. Needs the part lookup.wgsl.

// Nearest texel and the texel behind it along one side of a map, and the share
// of the second.
fn avsm_neighbours(position: f32, count: u32) -> vec3<f32> {
    // NaN is 0.
    let place = clamp(select(0.0, position, position > 0.5) - 0.5, 0.0, f32(count));
    let first = min(floor(place), f32(count - 1u));
    return vec3(first, min(first + 1.0, f32(count - 1u)), min(place - first, 1.0));
}

fn avsm_nearest(position: f32, count: u32) -> u32 {
    return min(u32(clamp(select(0.0, position, position > 0.0), 0.0, f32(count))), count - 1u);
}

// Share of the light that gets to a receiver, per channel, from a map of
// `extent` texels, at least one. Texel centres are at 0.5, 1.5, ...
fn avsm_filtered(
    extent: vec2<u32>,
    position: vec2<f32>,
    depth: f32,
    is_bilinear: bool,
) -> array<f32, avsm_CHANNELS> {
    if !is_bilinear {
        let texel = avsm_nearest(position.y, extent.y) * extent.x + avsm_nearest(position.x, extent.x);
        return avsm_transmittances(texel, depth);
    }
    let x = avsm_neighbours(position.x, extent.x);
    let y = avsm_neighbours(position.y, extent.y);
    let columns = vec2<u32>(x.xy);
    let rows = vec2<u32>(y.xy) * extent.x;
    let a = avsm_transmittances(rows.x + columns.x, depth);
    let b = avsm_transmittances(rows.x + columns.y, depth);
    let c = avsm_transmittances(rows.y + columns.x, depth);
    let d = avsm_transmittances(rows.y + columns.y, depth);
    var result: array<f32, avsm_CHANNELS>;
    for (var i = 0u; i < avsm_CHANNELS; i++) {
        let above = a[i] + (b[i] - a[i]) * x.z;
        let below = c[i] + (d[i] - c[i]) * x.z;
        result[i] = clamp(above + (below - above) * y.z, 0.0, 1.0);
    }
    return result;
}
