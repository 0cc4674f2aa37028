// The depths of a picture with one sample in each pixel.

const SAMPLES = 1u;

@group(0) @binding(1) var depths: texture_depth_2d;

fn depth_of(pixel: vec2<u32>, sample: u32) -> f32 {
    return textureLoad(depths, pixel, 0);
}
