"""Below the contracts: the executor, rates, waiting and waking. Pure, or given a clock."""
