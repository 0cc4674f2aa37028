// Stores curves as packed.wgsl reads them. Needs the part curve.wgsl and
//   fn avsm_set_word(index: u32, word: u32)    the words of the map
fn avsm_store(texel: u32, curve: ptr<function, avsm_Curve>) {
    let base = texel * avsm_WORDS;
    // Nodes that the curve does not have repeat its last one.
    let last = max((*curve).len, 1u) - 1u;
    for (var i = 0u; i < avsm_NODES; i++) {
        avsm_set_word(base + i, bitcast<u32>((*curve).depth[min(i, last)]));
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            var value = avsm_CLEAR;
            if (*curve).len > 0u {
                value = (*curve).value[c * avsm_CAPACITY + min(i, last)];
            }
            avsm_set_word(base + (1u + c) * avsm_NODES + i, bitcast<u32>(value));
        }
    }
}
