// The depths of a picture with four samples in each pixel.

const SAMPLES = 4u;

@group(0) @binding(1) var depths: texture_depth_multisampled_2d;

fn depth_of(pixel: vec2<u32>, sample: u32) -> f32 {
    return textureLoad(depths, pixel, sample);
}
