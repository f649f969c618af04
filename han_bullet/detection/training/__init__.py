"""How the weights in models/ are made from photographs."""
