// A segment in a unit of length, a power of two, in which its start is 1 to 3
// from the light, so that squares stay in range.

// Nothing to compute: a length of 0, numbers that are no lengths, or no light.
const air_EMPTY: u32 = 0u;
// The light is on the segment.
const air_MEETS_LIGHT: u32 = 1u;
const air_ORDINARY: u32 = 2u;

// A ray that passes the light more closely than this meets it. In the unit of the scaled
// segment, which is about the distance between its start and the light.
const air_NEAREST: f32 = 0x1p-100;

struct air_Scaled {
    kind: u32,
    // The unit is 2^exponent m.
    exponent: i32,
    // Extinction per unit.
    sigma: f32,
    // Start and end, 0 at the foot point, and the distance between ray and light.
    s: f32,
    end: f32,
    h: f32,
    // At most air_LONGEST.
    length: f32,
    // Distances of both ends from the light.
    d_start: f32,
    d_end: f32,
    // Optical depth of the way from the light by the start to the eye, over ln 2: light
    // falls by 2^-octaves.
    octaves: f32,
}

// A segment in its unit; empty if no light is left at its start.
fn air_scaled(sigma_t: f32, segment: air_Segment) -> air_Scaled {
    var part = air_scaled_lengths(sigma_t, segment);
    if part.kind != air_ORDINARY {
        return part;
    }
    let way = air_product(sigma_t, abs(segment.x));
    let depth = part.sigma * part.d_start + select(way, -way, segment.x < 0.0);
    // e^-400 is 2^-577, which is 0 whatever an f32 multiplies it with.
    if depth >= 0.0 && depth < 400.0 {
        part.octaves = air_LOG2_E * depth;
    } else {
        part.kind = air_EMPTY;
    }
    return part;
}

// The same without the optical depth of the way to the start, which may be any.
fn air_scaled_lengths(sigma_t: f32, segment: air_Segment) -> air_Scaled {
    var part: air_Scaled;
    part.kind = air_EMPTY;
    let length_bits = bitcast<i32>(segment.length);
    let are_lengths = air_is_finite(segment.x) && air_is_finite(segment.s) && air_is_finite(segment.h)
        && length_bits > 0 && length_bits <= 0x7f800000;
    if !(are_lengths && air_is_finite(sigma_t)) {
        return part;
    }
    if segment.h < 0.0 || sigma_t < 0.0 {
        return part;
    }
    // f32::MAX stands for infinity, with which a shader must not compute.
    let length = bitcast<f32>(min(length_bits, 0x7f7fffff));
    // h may be −0, whose sign bit would spoil the exponent below.
    let h = abs(segment.h);
    let largest = max(abs(segment.s), h);
    let exponent = clamp(i32(bitcast<u32>(largest) >> 23u) - 127, -126, 126);
    let per_unit = bitcast<f32>(u32(127 - exponent) << 23u);
    let unit = bitcast<f32>(u32(127 + exponent) << 23u);
    let longest = bitcast<f32>(u32(127 + min(exponent + 60, 127)) << 23u);
    part.exponent = exponent;
    part.s = segment.s * per_unit;
    part.h = h * per_unit;
    part.h = select(part.h, 0.0, part.h < air_NEAREST);
    part.length = min(length, longest) * per_unit;
    // Where the end is close to the light, this difference is exact.
    part.end = part.s + part.length;
    if part.h == 0.0 && part.s <= 0.0 && part.end >= 0.0 {
        part.kind = air_MEETS_LIGHT;
        return part;
    }
    part.d_start = air_distance(part.s, part.h);
    part.d_end = air_distance(part.end, part.h);
    part.sigma = air_product(sigma_t, unit);
    part.kind = air_ORDINARY;
    return part;
}
