"""FMUs for Model Exchange: slaves that bring equations and no solver; the solver is here."""
