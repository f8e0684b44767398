"""Training of the neural field that tells where a building is: shards in, one network file out."""
