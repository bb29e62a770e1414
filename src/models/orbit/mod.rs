//! The Earth around the Sun.
