// Which points of masked triangles are holes.
//
// Needs the variables
//   light_masks: array<light_Mask>, one per masked triangle
//   light_mask_opacities: array<f32>, the opacities of all textures

const light_MASK_CLAMP = 2u;
const light_MASK_MIRROR = 1u;

struct light_Mask {
    // Texture coordinates of the three corners.
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    // The opacity of material and vertex at the corners.
    opacity_a: f32,
    opacity_b: f32,
    opacity_c: f32,
    cutoff: f32,
    // The first texel of the texture, and its size; the width is 0 without a texture.
    first: u32,
    width: u32,
    height: u32,
    wrap_u: u32,
    wrap_v: u32,
    nearest: u32,
}

// A texture coordinate of the same texel in or next to the first copy of the texture, where
// an f32 can tell texels apart.
fn light_mask_near(coordinate: f32, wrap: u32) -> f32 {
    if wrap == light_MASK_CLAMP {
        return clamp(coordinate, 0.0, 1.0);
    }
    if wrap == light_MASK_MIRROR {
        return coordinate - 2.0 * floor(0.5 * coordinate);
    }
    return coordinate - floor(coordinate);
}

// The texel that is seen at `index` of a wrapped row of `count`.
fn light_mask_texel(index: i32, count: i32, wrap: u32) -> i32 {
    if wrap == light_MASK_CLAMP {
        return clamp(index, 0, count - 1);
    }
    let turn = select(count, 2 * count, wrap == light_MASK_MIRROR);
    let folded = (index % turn + turn) % turn;
    return min(folded, 2 * count - 1 - folded);
}

fn light_mask_opacity(mask: light_Mask, column: f32, row: f32) -> f32 {
    let x = light_mask_texel(i32(column), i32(mask.width), mask.wrap_u);
    let y = light_mask_texel(i32(row), i32(mask.height), mask.wrap_v);
    return light_mask_opacities[mask.first + u32(y) * mask.width + u32(x)];
}

fn light_mask_filtered(mask: light_Mask, uv: vec2<f32>) -> f32 {
    if mask.width == 0u {
        return 1.0;
    }
    let size = vec2(f32(mask.width), f32(mask.height));
    let scaled = vec2(light_mask_near(uv.x, mask.wrap_u), light_mask_near(uv.y, mask.wrap_v)) * size;
    if mask.nearest != 0u {
        let place = floor(scaled);
        return light_mask_opacity(mask, place.x, place.y);
    }
    let place = floor(scaled - 0.5);
    let f = scaled - 0.5 - place;
    let top = mix(light_mask_opacity(mask, place.x, place.y), light_mask_opacity(mask, place.x + 1.0, place.y), f.x);
    let bottom = mix(
        light_mask_opacity(mask, place.x, place.y + 1.0),
        light_mask_opacity(mask, place.x + 1.0, place.y + 1.0),
        f.x,
    );
    return mix(top, bottom, f.y);
}

// Whether a masked triangle has a hole at a point, given by the barycentric coordinates of
// its second and third corner.
fn light_mask_is_hole(number: u32, at: vec2<f32>) -> bool {
    let mask = light_masks[number];
    let w = 1.0 - at.x - at.y;
    let vertices = w * mask.opacity_a + at.x * mask.opacity_b + at.y * mask.opacity_c;
    let alpha = vertices * light_mask_filtered(mask, w * mask.a + at.x * mask.b + at.y * mask.c);
    return !(clamp(alpha, 0.0, 1.0) >= mask.cutoff);
}
