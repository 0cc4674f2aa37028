// Curves as `Packed` stores them. Needs
//   fn avsm_word(index: u32) -> u32    the words of the map

const avsm_WORDS: u32 = avsm_NODES * (1u + avsm_CHANNELS);

fn avsm_stored_len(texel: u32) -> u32 {
    return avsm_NODES;
}

fn avsm_stored_depth(texel: u32, node: u32) -> f32 {
    return bitcast<f32>(avsm_word(texel * avsm_WORDS + node));
}

fn avsm_stored_value(texel: u32, node: u32, channel: u32) -> f32 {
    return bitcast<f32>(avsm_word(texel * avsm_WORDS + (1u + channel) * avsm_NODES + node));
}

// A depth in the measure of the stored ones, which here is the same.
fn avsm_place(texel: u32, depth: f32) -> f32 {
    return depth;
}

// The depth of a place in that measure.
fn avsm_unplace(texel: u32, place: f32) -> f32 {
    return place;
}
