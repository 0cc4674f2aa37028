// Curves as `Curve` stores them, with their bounds. Needs
//   fn avsm_word(index: u32) -> u32    the words of the map

const avsm_WORDS: u32 = 2u + avsm_NODES * (1u + 3u * avsm_CHANNELS);

fn avsm_stored_len(texel: u32) -> u32 {
    return min(avsm_word(texel * avsm_WORDS), avsm_NODES);
}

// Number `node` of a row: depths, then values, bounds above and bounds below by
// channel.
fn avsm_stored_number(texel: u32, row: u32, node: u32) -> f32 {
    return bitcast<f32>(avsm_word(texel * avsm_WORDS + 2u + row * avsm_NODES + node));
}

fn avsm_stored_depth(texel: u32, node: u32) -> f32 {
    return avsm_stored_number(texel, 0u, node);
}

fn avsm_stored_value(texel: u32, node: u32, channel: u32) -> f32 {
    return avsm_stored_number(texel, 1u + channel, node);
}

// A depth in the measure of the stored ones.
fn avsm_place(texel: u32, depth: f32) -> f32 {
    return depth;
}

// The depth at a place in the measure of the stored ones.
fn avsm_unplace(texel: u32, place: f32) -> f32 {
    return place;
}
