// A part of a face of a shadow map that is rendered in one pass.

struct Tile {
    face: light_Face,
    // Takes the clip space of the face to that of the tile.
    scale: vec2<f32>,
    offset: vec2<f32>,
    // First texel of the tile in the face, and its size.
    first: vec2<u32>,
    size: vec2<u32>,
    // Texels per side of the face, and which face it is.
    resolution: u32,
    index: u32,
    // All casters are closer than this.
    far: f32,
    // Nothing closer than this casts a shadow.
    near: f32,
    // The number of solid triangles, which come before the masked ones.
    solid: u32,
    padding: u32,
    more_padding: vec2<u32>,
}
