"""What the larger maps are built with: pieces, their meshes, an exact nav-mesh, and the files around them."""
