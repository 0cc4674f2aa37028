//! Precomputed shadows of a picture's lights, from files.
