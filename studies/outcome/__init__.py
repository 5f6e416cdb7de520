"""What a run computed: numbers, tables and the summary, before anybody shows them."""
