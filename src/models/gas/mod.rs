//! Point particles in a circular container.
