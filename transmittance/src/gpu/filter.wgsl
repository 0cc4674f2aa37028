// Questions to a map between its texel centres. Needs the part lookup.wgsl.

// The two texels around a position along one side of a map, and the share of the second.
fn avsm_neighbours(position: f32, count: u32) -> vec3<f32> {
    // The comparison makes NaN 0.
    let place = clamp(select(0.0, position, position > 0.5) - 0.5, 0.0, f32(count));
    let first = min(floor(place), f32(count - 1u));
    return vec3(first, min(first + 1.0, f32(count - 1u)), min(place - first, 1.0));
}

// The texel that a position lies in, or the nearest one of the map.
fn avsm_nearest(position: f32, count: u32) -> u32 {
    return min(u32(clamp(select(0.0, position, position > 0.0), 0.0, f32(count))), count - 1u);
}

// Where a square begins that is `side` texels wide around a position. It covers parts of
// side + 1 texels.
fn avsm_square_start(position: f32, side: u32, count: u32) -> f32 {
    return clamp(select(0.0, position, position > 0.0), 0.0, f32(count)) - 0.5 * f32(side);
}

// How much of the i-th texel such a square covers, along one side: the first and the last
// one in part.
fn avsm_covered(i: u32, side: u32, start: f32) -> f32 {
    let beside = start - floor(start);
    return select(select(1.0, beside, i == side), 1.0 - beside, i == 0u);
}

// The i-th texel of the square; beside the map it is the one at its rim.
fn avsm_square_texel(i: u32, start: f32, count: u32) -> u32 {
    return u32(clamp(floor(start) + f32(i), 0.0, f32(count - 1u)));
}

// Share of the light that gets to a receiver, per channel, from a map of `extent` texels,
// at least one. Texel centres are at 0.5, 1.5, … The result is the mean over a square of
// `side` texels per side, at most 255; 0 takes the nearest texel, 1 interpolates between
// the four around.
fn avsm_filtered(
    extent: vec2<u32>,
    position: vec2<f32>,
    depth: f32,
    side: u32,
) -> array<f32, avsm_CHANNELS> {
    if side == 0u {
        let texel = avsm_nearest(position.y, extent.y) * extent.x + avsm_nearest(position.x, extent.x);
        return avsm_transmittances(texel, depth);
    }
    if side > 1u {
        return avsm_square(extent, position, depth, min(side, 255u));
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

// The mean over a square of two and more texels per side.
fn avsm_square(
    extent: vec2<u32>,
    position: vec2<f32>,
    depth: f32,
    side: u32,
) -> array<f32, avsm_CHANNELS> {
    let left = avsm_square_start(position.x, side, extent.x);
    let top = avsm_square_start(position.y, side, extent.y);
    var result: array<f32, avsm_CHANNELS>;
    for (var i = 0u; i <= side; i++) {
        let row = avsm_square_texel(i, top, extent.y) * extent.x;
        var sum: array<f32, avsm_CHANNELS>;
        for (var j = 0u; j <= side; j++) {
            let texel = avsm_transmittances(row + avsm_square_texel(j, left, extent.x), depth);
            let weight = avsm_covered(j, side, left);
            for (var c = 0u; c < avsm_CHANNELS; c++) {
                sum[c] += texel[c] * weight;
            }
        }
        let weight = avsm_covered(i, side, top);
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            result[c] += sum[c] * weight;
        }
    }
    let mean = 1.0 / f32(side * side);
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        result[c] = clamp(result[c] * mean, 0.0, 1.0);
    }
    return result;
}
