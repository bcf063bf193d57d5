"""How right a result is: the certificate of a run, convergence over the macro step, the monolith as reference."""
