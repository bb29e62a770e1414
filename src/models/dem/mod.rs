//! Spring–dashpot discs in a box.
