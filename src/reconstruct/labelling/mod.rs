//! Labelling (paper, section 3.4): a Markov random field over the cells, solved exactly by an s-t cut.
