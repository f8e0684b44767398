//! Whole pipelines on small clouds whose results follow by hand.
