// Airlight from the table of Sun et al.: the shader's side of `SunTable`.
//
// Needs
//   fn air_sun_table_rows() -> f32                rows per mean free path of h
//   fn air_sun_table_value(index: u32) -> f32     a value, row by row

// Values of a row, and rows.
const air_SUN_TABLE_SIDE: u32 = 512u;
const air_SUN_TABLE_PI: f32 = 3.14159274;

// Airlight per unit of σ_s I, in 1/(m sr).
fn air_sun_table_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    let length_bits = bitcast<i32>(segment.length);
    let are_lengths = air_is_finite(segment.x) && air_is_finite(segment.s) && air_is_finite(segment.h)
        && length_bits > 0 && length_bits <= 0x7f800000;
    if !(are_lengths && air_is_finite(sigma_t)) {
        return 0.0;
    }
    if segment.h < 0.0 || sigma_t < 0.0 {
        return 0.0;
    }
    // h may be −0, whose sign bit would spoil the exponent below.
    let h = abs(segment.h);
    let length = min(bitcast<f32>(min(length_bits, 0x7f7fffff)), 0x1p+126);
    let s = clamp(segment.s, -0x1p+126, 0x1p+126);
    let end = s + length;
    if bitcast<u32>(h) < 0x00800000u {
        return select(0.0, air_FAR, s <= 0.0 && end >= 0.0);
    }
    let row = air_sun_table_split(air_product(sigma_t, h) * air_sun_table_rows());
    let difference = air_sun_table_row(row, end, h) - air_sun_table_row(row, s, h);
    let way = s - clamp(segment.x, -0x1p+126, 0x1p+126);
    let octaves = air_LOG2_E * air_product(sigma_t, abs(way));
    let power = min(select(octaves, -octaves, way < 0.0), 127.0);
    // The factor in front of the difference may leave the range of f32 where the product
    // does not; it counts as 0 or infinite then, as in the published method.
    if !(difference > 0.0) || power <= -100.0 {
        return 0.0;
    }
    let exponent = i32(bitcast<u32>(h) >> 23u) - 127;
    let mantissa = bitcast<f32>((bitcast<u32>(h) & 0x7fffffu) | 0x3f800000u);
    let per_length = 0.5 / (air_SUN_TABLE_PI * mantissa);
    if air_exp2_times(per_length, power, -exponent) == air_FAR {
        return air_FAR;
    }
    return air_exp2_times(difference * per_length, power, -exponent);
}

// F at the position s of the ray, interpolated between two rows.
fn air_sun_table_row(row: vec2<f32>, s: f32, h: f32) -> f32 {
    let far = abs(s);
    let angle_to_axis = air_sun_table_arctan(min(far, h) / max(far, h));
    let half_turn = 0.5 * air_SUN_TABLE_PI;
    let angle = select(half_turn - angle_to_axis, angle_to_axis, far < h);
    let v = 0.25 * air_SUN_TABLE_PI + 0.5 * select(angle, -angle, s < 0.0);
    let column = air_sun_table_split(v * (f32(air_SUN_TABLE_SIDE - 1u) / half_turn));
    let first = u32(row.x) * air_SUN_TABLE_SIDE + u32(column.x);
    let above = air_sun_table_pair(first, column.y);
    let below = air_sun_table_pair(first + air_SUN_TABLE_SIDE, column.y);
    return above + row.y * (below - above);
}

// F interpolated between two neighbours along v.
fn air_sun_table_pair(index: u32, along: f32) -> f32 {
    let before = air_sun_table_value(index);
    return before + along * (air_sun_table_value(index + 1u) - before);
}

// The entry before a position, and how far the position is behind it, 0 to 1.
fn air_sun_table_split(position: f32) -> vec2<f32> {
    let inside = clamp(position, 0.0, f32(air_SUN_TABLE_SIDE - 1u) - 0.001);
    let entry = floor(inside);
    return vec2(entry, inside - entry);
}

// arctan z for z from 0 to 1, with a relative error of at most 8e-7; WGSL's own may be
// off by 4096 ULP. The polynomial interpolates in Chebyshev nodes of z².
fn air_sun_table_arctan(z: f32) -> f32 {
    let q = z * z;
    let near_half = 0.1987204 + q * (-0.13447864 + q * (0.08312645 + q * (-0.03636043 + q * 0.007648354)));
    return z * (0.9999992 + q * (-0.3332568 + q * near_half));
}
